#include "evaluation/absolute_trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace matchbox_slam {
namespace {

struct Centroids {
  Eigen::Vector2d estimate = Eigen::Vector2d::Zero();
  Eigen::Vector2d truth = Eigen::Vector2d::Zero();
};

Centroids centroids(const std::vector<PosePair>& pairs) {
  Centroids mean;
  for (const PosePair& pair : pairs) {
    mean.estimate += pair.estimate.translation();
    mean.truth += pair.truth.translation();
  }
  mean.estimate /= static_cast<double>(pairs.size());
  mean.truth /= static_cast<double>(pairs.size());
  return mean;
}

double mean_heading_difference(const std::vector<PosePair>& pairs) {
  double cosine = 0.0;
  double sine = 0.0;
  for (const PosePair& pair : pairs) {
    cosine += std::cos(pair.truth.theta - pair.estimate.theta);
    sine += std::sin(pair.truth.theta - pair.estimate.theta);
  }
  return std::atan2(sine, cosine);
}

// [m], root mean square of the true positions about their middle: below, the robot rests or turns
// in place, and which rotation fits the positions best is up to their noise.
constexpr double kRestRadius = 0.05;

/// The rotation about the centroids of least squared distance: the sums are the cosine and the sine
/// of it, times the spread of the positions.
double rotation_between(const std::vector<PosePair>& pairs, const Centroids& mean) {
  double cosine = 0.0;
  double sine = 0.0;
  double spread = 0.0;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector2d e = pair.estimate.translation() - mean.estimate;
    const Eigen::Vector2d t = pair.truth.translation() - mean.truth;
    cosine += e.dot(t);
    sine += e.x() * t.y() - e.y() * t.x();
    spread += t.squaredNorm();
  }
  const bool is_open = spread <= kRestRadius * kRestRadius * static_cast<double>(pairs.size());
  return is_open ? mean_heading_difference(pairs) : std::atan2(sine, cosine);
}

}  // namespace

Pose2 align_se2(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) {
    throw EvaluationError("no poses to align");
  }
  const Centroids mean = centroids(pairs);
  const Pose2 rotation{0.0, 0.0, wrap_angle(rotation_between(pairs, mean))};
  const Eigen::Vector2d shift = mean.truth - rotation * mean.estimate;
  return {shift.x(), shift.y(), rotation.theta};
}

AbsoluteTrajectoryError absolute_trajectory_error(const Trajectory& estimate,
                                                  const Trajectory& truth,
                                                  const AbsoluteTrajectoryErrorOptions& options) {
  std::vector<PosePair> pairs = associate_some(estimate, truth, options.max_gap);
  if (estimate.size() < 2 && options.alignment == Alignment::kSe2) {
    throw EvaluationError(
        "the estimate is one pose alone, which has no error when it is aligned with the truth: at "
        "least 2 poses are needed, or alignment none");
  }
  if (pairs.size() < 2 && estimate.size() > 1) {
    throw EvaluationError("only 1 of " + std::to_string(estimate.size()) +
                          " poses of the estimate has truth, and one alone has no error; the "
                          "estimate is from " +
                          time_range_text(estimate) + ", the truth from " + time_range_text(truth) +
                          "; are both in the same clock?");
  }
  AbsoluteTrajectoryError result;
  result.alignment = options.alignment;
  result.without_truth = estimate.size() - pairs.size();
  if (options.alignment == Alignment::kSe2) {
    result.truth_from_estimate = align_se2(pairs);
  }
  std::vector<double> distances;
  double squared_headings = 0.0;
  for (PosePair& pair : pairs) {
    pair.estimate = result.truth_from_estimate * pair.estimate;
    distances.push_back((pair.estimate.translation() - pair.truth.translation()).norm());
    squared_headings += std::pow(wrap_angle(pair.estimate.theta - pair.truth.theta), 2);
  }
  result.translation = summarize_errors(distances);
  result.heading_rmse = std::sqrt(squared_headings / static_cast<double>(pairs.size()));
  result.aligned_pairs = std::move(pairs);
  return result;
}

}  // namespace matchbox_slam
