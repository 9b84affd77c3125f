#include "evaluation/clock_offset.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/number_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"

namespace matchbox_slam {
namespace {

// [s]; the coarse one is well below the time in which a robot changes its motion.
constexpr double kCoarseStep = 0.25;
constexpr double kFineStep = 0.01;
constexpr std::size_t kMostPoses = 2000;
constexpr std::size_t kFewestPoses = 3;    // two positions and their distance fit too easily
constexpr std::size_t kRefinedMinima = 5;  // the fine grid may reorder what the coarse one ranks
// An offset away from the best one is a rival when its error is at most this much larger. These and
// what follows are guesses: half and double were not tried.
constexpr double kAboutAsGoodFactor = 1.25;
constexpr double kAboutAsGoodExtra = 0.005;  // [m], below this errors are noise
constexpr double kSameMinimum = 3.0;         // [s]; nearer ones belong to one valley of the curve
// What a right offset leaves: positions within a share of the path's extent, and headings, which
// took no part in the search, within a share of their own spread and a little noise.
constexpr double kMostOfExtent = 0.1;
constexpr double kMostOfHeadings = 0.05;
constexpr double kHeadingNoise = 0.02;  // [rad]
constexpr double kNoHeadings = 1e-6;    // [rad], spread of what holds no headings but a constant

using Curve = std::vector<ClockOffsetFit>;

std::string seconds(double value) { return fixed_text(value, 2) + " s"; }
std::string metres(double value) { return fixed_text(value, 4) + " m"; }

std::vector<StampedPose2> thinned(const std::vector<StampedPose2>& poses) {
  const std::size_t step = (poses.size() + kMostPoses - 1) / kMostPoses;
  std::vector<StampedPose2> kept;
  for (std::size_t i = 0; i < poses.size(); i += step) {
    kept.push_back(poses[i]);
  }
  return kept;
}

double aligned_rmse(const std::vector<PosePair>& pairs) {
  const Pose2 truth_from_estimate = align_se2(pairs);
  double squares = 0.0;
  for (const PosePair& pair : pairs) {
    squares += (truth_from_estimate * pair.estimate.translation() - pair.truth.translation())
                   .squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

std::vector<PosePair> pairs_at(double offset, const std::vector<StampedPose2>& estimate,
                               const Trajectory& truth, double max_gap) {
  std::vector<PosePair> pairs;
  pairs.reserve(estimate.size());
  for (const StampedPose2& estimated : estimate) {
    if (const std::optional<Pose2> pose = truth.at(estimated.stamp - offset, max_gap)) {
      pairs.push_back({estimated.stamp, estimated.pose, *pose});
    }
  }
  return pairs;
}

/// None when too few poses have truth at this offset to be aligned.
std::optional<ClockOffsetFit> fit_at(double offset, const std::vector<StampedPose2>& estimate,
                                     const Trajectory& truth, double max_gap) {
  const std::vector<PosePair> pairs = pairs_at(offset, estimate, truth, max_gap);
  if (pairs.size() < kFewestPoses) {
    return std::nullopt;
  }
  return ClockOffsetFit{offset, aligned_rmse(pairs), pairs.size()};
}

/// Drops the fits of few poses compared with the one of most.
void require_overlap(double min_overlap, Curve& curve) {
  std::size_t most = 0;
  for (const ClockOffsetFit& fit : curve) {
    most = std::max(most, fit.poses);
  }
  const double enough = min_overlap * static_cast<double>(most);
  curve.erase(std::remove_if(curve.begin(), curve.end(),
                             [&](const ClockOffsetFit& fit) {
                               return static_cast<double>(fit.poses) < enough;
                             }),
              curve.end());
}

/// Every multiple of the coarse step in the range at which enough poses have truth.
Curve coarse_curve(const std::vector<StampedPose2>& estimate, const Trajectory& truth,
                   const ClockOffsetOptions& options) {
  Curve curve;
  const auto steps = static_cast<int>(options.range / kCoarseStep);
  for (int i = -steps; i <= steps; ++i) {
    if (const auto fit = fit_at(i * kCoarseStep, estimate, truth, options.max_gap)) {
      curve.push_back(*fit);
    }
  }
  require_overlap(options.min_overlap, curve);
  return curve;
}

/// The offsets of the lowest local minima, the ends included.
std::vector<double> lowest_minima(const Curve& curve) {
  Curve minima;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const bool falls_before = i == 0 || curve[i - 1].rmse >= curve[i].rmse;
    const bool rises_after = i + 1 == curve.size() || curve[i + 1].rmse >= curve[i].rmse;
    if (falls_before && rises_after) {
      minima.push_back(curve[i]);
    }
  }
  std::sort(minima.begin(), minima.end(),
            [](const ClockOffsetFit& a, const ClockOffsetFit& b) { return a.rmse < b.rmse; });
  minima.resize(std::min(minima.size(), kRefinedMinima));
  std::vector<double> offsets;
  for (const ClockOffsetFit& minimum : minima) {
    offsets.push_back(minimum.offset);
  }
  return offsets;
}

/// Offsets around one, at the fine step.
void add_fine_fits(double center, const std::vector<StampedPose2>& estimate,
                   const Trajectory& truth, const ClockOffsetOptions& options, Curve& curve) {
  const auto steps = static_cast<int>(std::lround(kCoarseStep / kFineStep));
  for (int i = -steps; i <= steps; ++i) {
    const double offset = center + i * kFineStep;
    const bool is_known = i == 0 || std::abs(i) == steps;  // from the coarse grid
    if (is_known || std::abs(offset) > options.range) {
      continue;
    }
    if (const auto fit = fit_at(offset, estimate, truth, options.max_gap)) {
      curve.push_back(*fit);
    }
  }
}

void require_an_inner_minimum(const Curve& curve, const ClockOffsetFit& best, double range) {
  if (best.offset > curve.front().offset && best.offset < curve.back().offset) {
    return;
  }
  const bool is_end_of_range = std::abs(best.offset) > range - kCoarseStep;
  throw EvaluationError(
      "no clock offset found: the error is least, " + metres(best.rmse) + ", at " +
      seconds(best.offset) + ", which is " +
      (is_end_of_range ? "the end of the range searched; search a wider one"
                       : "where estimate and truth barely overlap enough; are they of the same "
                         "drive?"));
}

/// The lowest fit far from the best one that is about as good; null when there is none.
const ClockOffsetFit* rival_of(const ClockOffsetFit& best, const Curve& curve, double limit) {
  const ClockOffsetFit* rival = nullptr;
  for (const ClockOffsetFit& fit : curve) {
    const bool is_far = std::abs(fit.offset - best.offset) > kSameMinimum;
    if (is_far && fit.rmse <= limit && (rival == nullptr || fit.rmse < rival->rmse)) {
      rival = &fit;
    }
  }
  return rival;
}

/// What else fits about as well tells whether the best offset means anything.
void require_a_distinct_minimum(const Curve& curve, const ClockOffsetFit& best) {
  const double limit = kAboutAsGoodFactor * best.rmse + kAboutAsGoodExtra;
  const ClockOffsetFit* rival = rival_of(best, curve, limit);
  if (rival == nullptr) {
    return;
  }
  const double low = std::min(best.offset, rival->offset);
  const double high = std::max(best.offset, rival->offset);
  const bool is_flat = std::all_of(curve.begin(), curve.end(), [&](const ClockOffsetFit& fit) {
    return fit.offset < low || fit.offset > high || fit.rmse <= limit;
  });
  const std::string both = "the error is " + metres(best.rmse) + " at " + seconds(best.offset) +
                           " and " + metres(rival->rmse) + " at " + seconds(rival->offset);
  throw EvaluationError(
      is_flat ? "no clock offset found: the error hardly depends on it (" + both +
                    "), as when the robot rests, drives straight or in circles, or the estimate "
                    "is poor; give the offset"
              : "no clock offset found: two fit about equally well (" + both +
                    "), as when the robot repeats its path; search a smaller range or give the "
                    "offset");
}

/// Root mean square distance of angles from their mean direction [rad].
double angular_spread(const std::vector<double>& angles) {
  double cosine = 0.0;
  double sine = 0.0;
  for (const double angle : angles) {
    cosine += std::cos(angle);
    sine += std::sin(angle);
  }
  double squares = 0.0;
  for (const double angle : angles) {
    squares += std::pow(wrap_angle(angle - std::atan2(sine, cosine)), 2);
  }
  return std::sqrt(squares / static_cast<double>(angles.size()));
}

/// Root mean square distance of the true positions from their centroid [m].
double extent_of(const std::vector<PosePair>& pairs) {
  const auto count = static_cast<double>(pairs.size());
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const PosePair& pair : pairs) {
    centroid += pair.truth.translation() / count;
  }
  double squares = 0.0;
  for (const PosePair& pair : pairs) {
    squares += (pair.truth.translation() - centroid).squaredNorm();
  }
  return std::sqrt(squares / count);
}

[[noreturn]] void throw_no_fit(const ClockOffsetFit& best, const std::string& what) {
  throw EvaluationError("no clock offset found: even at " + seconds(best.offset) +
                        ", where estimate and truth fit best, " + what +
                        "; are they of one body on one drive, and do they overlap enough?");
}

void require_positions_that_fit(const ClockOffsetFit& best, const std::vector<PosePair>& pairs) {
  const double extent = extent_of(pairs);
  if (best.rmse > kMostOfExtent * extent) {
    throw_no_fit(best, "positions differ by " + metres(best.rmse) + " on a path that extends " +
                           metres(extent) + " about its middle");
  }
}

/// A body may be mounted at any angle, so a constant difference of headings is none.
void require_headings_that_fit(const ClockOffsetFit& best, const std::vector<PosePair>& pairs) {
  std::vector<double> estimated;
  std::vector<double> actual;
  std::vector<double> differences;
  for (const PosePair& pair : pairs) {
    estimated.push_back(pair.estimate.theta);
    actual.push_back(pair.truth.theta);
    differences.push_back(pair.estimate.theta - pair.truth.theta);
  }
  const double spread = angular_spread(actual);
  if (spread < kNoHeadings || angular_spread(estimated) < kNoHeadings) {
    return;
  }
  const double difference = angular_spread(differences);
  if (difference > kHeadingNoise + kMostOfHeadings * spread) {
    throw_no_fit(best, "headings differ by " + fixed_text(difference, 3) + " rad" +
                           " and not by a constant angle");
  }
}

/// Where the parabola through the squared errors at the minimum and its neighbours has its least:
/// near the right offset the squared error grows with the square of the offset's error.
double between_the_grid(const Curve& curve, std::size_t i) {
  const double left = curve[i - 1].offset - curve[i].offset;
  const double right = curve[i + 1].offset - curve[i].offset;
  const auto rise = [&](std::size_t k) {
    return curve[k].rmse * curve[k].rmse - curve[i].rmse * curve[i].rmse;
  };
  // From y = a d^2 + b d through both neighbours, d the distance from the minimum.
  const double a = (rise(i + 1) / right - rise(i - 1) / left) / (right - left);
  const double b = rise(i + 1) / right - a * right;
  return a > 0.0 ? curve[i].offset - b / (2.0 * a) : curve[i].offset;
}

void check(const Trajectory& estimate, const Trajectory& truth, const ClockOffsetOptions& options) {
  if (!(options.range > 0.0) || !(options.range <= ClockOffsetOptions::kWidestRange) ||
      !(options.max_gap > 0.0) || !(options.min_overlap > 0.0) || !(options.min_overlap <= 1.0)) {
    throw std::invalid_argument("options of the search for a clock offset that are not allowed");
  }
  require_poses(estimate, truth);
}

void refine(const std::vector<StampedPose2>& estimate, const Trajectory& truth,
            const ClockOffsetOptions& options, Curve& curve) {
  for (const double offset : lowest_minima(curve)) {
    add_fine_fits(offset, estimate, truth, options, curve);
  }
  require_overlap(options.min_overlap, curve);
  std::sort(curve.begin(), curve.end(),
            [](const ClockOffsetFit& a, const ClockOffsetFit& b) { return a.offset < b.offset; });
  // Neighbouring minima share offsets of the fine grid.
  curve.erase(std::unique(curve.begin(), curve.end(),
                          [](const ClockOffsetFit& a, const ClockOffsetFit& b) {
                            return b.offset - a.offset < 0.5 * kFineStep;
                          }),
              curve.end());
}

}  // namespace

ClockOffset find_clock_offset(const Trajectory& estimate, const Trajectory& truth,
                              const ClockOffsetOptions& options) {
  check(estimate, truth, options);
  const std::vector<StampedPose2> poses = thinned(estimate.poses());
  Curve curve = coarse_curve(poses, truth, options);
  if (curve.empty()) {
    throw EvaluationError("no clock offset found: with none of up to " + seconds(options.range) +
                          " do 3 poses of the estimate have truth; the estimate is from " +
                          time_range_text(estimate) + ", the truth from " + time_range_text(truth));
  }
  refine(poses, truth, options, curve);
  const auto best = std::min_element(
      curve.begin(), curve.end(),
      [](const ClockOffsetFit& a, const ClockOffsetFit& b) { return a.rmse < b.rmse; });
  require_a_distinct_minimum(curve, *best);
  require_an_inner_minimum(curve, *best, options.range);
  const std::vector<PosePair> pairs = pairs_at(best->offset, poses, truth, options.max_gap);
  require_positions_that_fit(*best, pairs);
  require_headings_that_fit(*best, pairs);
  const double offset = between_the_grid(curve, static_cast<std::size_t>(best - curve.begin()));
  return {offset, std::move(curve)};
}

}  // namespace matchbox_slam
