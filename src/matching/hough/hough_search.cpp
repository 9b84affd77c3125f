#include "matching/hough/hough_search.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matching/hough/likelihood_lookup.hpp"

namespace matchbox_slam {
namespace {

// [m]; beyond, none sees what another does.
constexpr double kFarthestKeyScan = 2.0 * kFarthestPoint;

/// The prior as seen from the key scan.
MotionGuess guess_of(const PosePrior& prior, const Pose2& map_from_key) {
  MotionGuess guess;
  guess.reference_from_scan = map_from_key.inverse() * prior.map_from_base;
  guess.covariance = in_turned_frame(prior.covariance, map_from_key.theta);
  return guess;
}

/// A unit vector along which the columns say little of an alignment, in the key scan's frame; none
/// where they hold every direction.
std::optional<Eigen::Vector2d> weak_axis(const HoughAlignment& alignment) {
  // Eigenvalue over the largest one; half or double: intel within 3 %.
  constexpr double kMaxEigenvalueRatio = 0.1;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(alignment.information);
  if (solver.eigenvalues()(0) > kMaxEigenvalueRatio * solver.eigenvalues()(1)) {
    return std::nullopt;
  }
  return solver.eigenvectors().col(0);
}

/// The poses that an alignment stands for: itself, and where its columns leave an axis open, the
/// ones along that axis within the guess's window, if the guess says next to nothing.
std::vector<Pose2> poses_along(const HoughAlignment& alignment, const MotionGuess& guess,
                               const HoughAlignmentOptions& options) {
  // The mean relation of hough in intel is 0.074 m; with half or double of the step 0.072 and
  // 0.078, of the window 0.088 and 0.153.
  constexpr double kStep = 0.05;      // [m], a cell of the key scan's field
  constexpr double kMinWindow = 0.6;  // [m] to each side; a narrower window is left to the guess
  std::vector<Pose2> poses = {alignment.reference_from_scan};
  if (const std::optional<Eigen::Vector2d> axis = weak_axis(alignment)) {
    const double variance = axis->dot(guess.covariance.topLeftCorner<2, 2>() * *axis);
    const double reach =
        std::min(options.max_window_xy, options.window_sigmas * std::sqrt(std::max(0.0, variance)));
    for (double step = -reach; reach > kMinWindow && step <= reach; step += kStep) {
      const Eigen::Vector2d at = guess.reference_from_scan.translation();
      const Eigen::Vector2d here = alignment.reference_from_scan.translation();
      const Eigen::Vector2d moved = here + (axis->dot(at - here) + step) * *axis;
      poses.push_back({moved.x(), moved.y(), alignment.reference_from_scan.theta});
    }
  }
  return poses;
}

/// About so many of the points, spread evenly.
HoughPoints thinned_out(const HoughPoints& points, std::size_t about) {
  const std::size_t stride = std::max<std::size_t>(1, points.size() / about);
  HoughPoints few;
  few.reach = points.reach;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    few.x.push_back(points.x[i]);
    few.y.push_back(points.y[i]);
    few.weight.push_back(points.weight[i]);
  }
  return few;
}

double mean_likelihood(const HoughPoints& points, const Pose2& field_from_points,
                       LikelihoodLookup& lookup) {
  lookup.turn(points, field_from_points.theta);
  return lookup.mean_at(field_from_points.translation());
}

/// Adds the first pose, and of the others, which lie in a row, those that score more than their
/// neighbours.
void add_peaks(const std::vector<RankedPose>& row, std::vector<RankedPose>& poses) {
  poses.push_back(row.front());
  for (std::size_t i = 1; i < row.size(); ++i) {
    const bool above_last = i == 1 || row[i].score >= row[i - 1].score;
    const bool above_next = i + 1 == row.size() || row[i].score > row[i + 1].score;
    if (above_last && above_next) {
      poses.push_back(row[i]);
    }
  }
}

}  // namespace

double mutual_violation(const SearchedScan& a, const SearchedScan& b, const Pose2& a_from_b) {
  return 0.5 * (a.view.contradicted(b.points, a_from_b) +
                b.view.contradicted(a.points, a_from_b.inverse()));
}

KeyScanSearch search_key_scan(const SearchedScan& scan, const PlacedScan& key,
                              const PosePrior& prior, double prior_weight,
                              const HoughAlignmentOptions& options, std::size_t most) {
  if (!((prior.map_from_base.translation() - key.map_from_base.translation()).norm() <
        kFarthestKeyScan)) {
    return {};
  }
  constexpr double kLeastVariance = 1e-6;  // (1 mm)^2, (1 mrad)^2: alignments are no more exact
  const Eigen::Matrix3d information =
      prior_information(prior.covariance + kLeastVariance * Eigen::Matrix3d::Identity());
  const SearchedScan reference(*key.scan->points(), options.point_spacing);
  const std::shared_ptr<const LikelihoodField> field = key.scan->field();
  const MotionGuess guess = guess_of(prior, key.map_from_base);
  // Where a few poses of thousands are wanted, a share of the points chooses which ones are ranked.
  constexpr std::size_t kRoughPoints = 64;
  constexpr std::size_t kRankedForEach = 24;
  const bool is_rough = most < kRankedPoses;
  const HoughPoints few = is_rough ? thinned_out(scan.points, kRoughPoints) : HoughPoints{};
  const HoughPoints& ranked_by = is_rough ? few : scan.points;
  LikelihoodLookup lookup(*field);
  std::size_t ranked = 0;
  std::vector<RankedPose> poses;
  for (const HoughAlignment& alignment :
       align_in_hough_domain(reference.points, scan.points, guess, options)) {
    lookup.turn(ranked_by, alignment.reference_from_scan.theta);
    std::vector<RankedPose> along;
    for (const Pose2& key_from_base : poses_along(alignment, guess, options)) {
      const Pose2 pose = key.map_from_base * key_from_base;
      const Eigen::Vector3d off = difference(pose, prior.map_from_base);
      const double penalty = prior_weight * prior_penalty(off.dot(information * off));
      along.push_back({pose, lookup.mean_at(key_from_base.translation()) - penalty});
    }
    ranked += along.size();
    add_peaks(along, poses);
  }
  if (is_rough) {
    sort_and_thin(poses, kRankedForEach * most);
    for (RankedPose& pose : poses) {
      const Pose2 key_from_base = key.map_from_base.inverse() * pose.map_from_base;
      pose.score += mean_likelihood(scan.points, key_from_base, lookup) -
                    mean_likelihood(few, key_from_base, lookup);
    }
  }
  sort_and_thin(poses, most);
  for (RankedPose& pose : poses) {
    pose.score -=
        mutual_violation(reference, scan, key.map_from_base.inverse() * pose.map_from_base);
  }
  sort_and_thin(poses);
  return {std::move(poses), ranked};
}

bool is_near_any(const RankedPose& pose, const std::vector<RankedPose>& others) {
  // Two cells, and the angle that moves a point 2 m away as far: refinement makes one of such
  // poses.
  constexpr double kSameXy = 0.1;      // [m]
  constexpr double kSameTheta = 0.05;  // [rad]
  return std::any_of(others.begin(), others.end(), [&](const RankedPose& other) {
    const Eigen::Vector3d apart = difference(pose.map_from_base, other.map_from_base);
    return apart.head<2>().norm() <= kSameXy && std::abs(apart.z()) <= kSameTheta;
  });
}

void sort_and_thin(std::vector<RankedPose>& poses, std::size_t most) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const RankedPose& a, const RankedPose& b) { return a.score > b.score; });
  std::vector<RankedPose> kept;
  for (std::size_t i = 0; i < poses.size() && kept.size() < most; ++i) {
    if (!is_near_any(poses[i], kept)) {
      kept.push_back(poses[i]);
    }
  }
  poses = std::move(kept);
}

}  // namespace matchbox_slam
