#include "evaluation/relative_pose_error.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

namespace matchbox_slam {
namespace {

/// [s], [m] or [rad]: distances from the step that differ by less are equal, else rounding would
/// choose between them (stamps of today resolve 2e-7 s).
constexpr double kRounding = 1e-6;

/// A pose of the estimate that has truth, with how far the robot had come.
struct Station {
  PosePair poses;
  double path = 0.0;        ///< [m] along the truth since its first pose
  double turning = 0.0;     ///< [rad] likewise
  std::size_t stretch = 0;  ///< of the truth without gaps
};

using Stations = std::vector<Station>;

/// Walks along truth and pairs at once; both are ordered by stamp.
Stations stations_of(const std::vector<PosePair>& pairs, const Trajectory& truth, double max_gap) {
  Stations stations;
  const std::vector<StampedPose2>& poses = truth.poses();
  std::size_t last = 0;  // pose of the truth not after the station
  double path = 0.0;
  double turning = 0.0;
  std::size_t stretch = 0;
  for (const PosePair& pair : pairs) {
    for (; last + 1 < poses.size() && poses[last + 1].stamp <= pair.stamp; ++last) {
      path += (poses[last + 1].pose.translation() - poses[last].pose.translation()).norm();
      turning += std::abs(wrap_angle(poses[last + 1].pose.theta - poses[last].pose.theta));
      stretch += poses[last + 1].stamp - poses[last].stamp > max_gap ? 1 : 0;
    }
    const double beyond = (pair.truth.translation() - poses[last].pose.translation()).norm();
    const double turned_beyond = std::abs(wrap_angle(pair.truth.theta - poses[last].pose.theta));
    stations.push_back({pair, path + beyond, turning + turned_beyond, stretch});
  }
  return stations;
}

/// How far the second station is from the first, in the unit of the rule.
double progress(const Station& first, const Station& second, PairRule::Unit unit) {
  if (unit == PairRule::Unit::kMetre) {
    return second.path - first.path;
  }
  if (unit == PairRule::Unit::kRadian) {
    return second.turning - first.turning;
  }
  return second.poses.stamp - first.poses.stamp;
}

/// Where the stations end whose progress from this one is known: path and turning are within a
/// stretch.
Stations::const_iterator end_of_known(Stations::const_iterator first, const Stations& stations,
                                      PairRule::Unit unit) {
  if (unit == PairRule::Unit::kSecond) {
    return stations.end();
  }
  return std::upper_bound(
      first, stations.end(), first->stretch,
      [](std::size_t stretch, const Station& station) { return stretch < station.stretch; });
}

/// The station after the first whose progress is nearest to the step; of several the earliest.
/// Null when it is none within the tolerance.
const Station* partner_by_progress(Stations::const_iterator first, const Stations& stations,
                                   const PairRule& rule, double tolerance) {
  const auto end = end_of_known(first, stations, rule.unit);
  if (std::next(first) == end) {
    return nullptr;
  }
  const auto first_at = [&](double distance) {
    return std::lower_bound(std::next(first), end, distance - kRounding,
                            [&](const Station& station, double wanted) {
                              return progress(*first, station, rule.unit) < wanted;
                            });
  };
  const auto distance = [&](Stations::const_iterator station) {
    return std::abs(progress(*first, *station, rule.unit) - rule.step);
  };
  auto nearest = first_at(rule.step);
  if (nearest == end || (nearest != std::next(first) &&
                         distance(std::prev(nearest)) <= distance(nearest) + kRounding)) {
    // Where the robot rested, several stations have come equally far.
    nearest = first_at(progress(*first, *std::prev(nearest), rule.unit));
  }
  const bool is_near = distance(nearest) <= tolerance * rule.step + kRounding;
  return is_near ? &*nearest : nullptr;
}

const Station* partner(Stations::const_iterator first, const Stations& stations,
                       const PairRule& rule, double tolerance) {
  if (rule.unit == PairRule::Unit::kScan) {
    const auto next = std::next(first);
    const bool is_pair = next != stations.end() && next->poses.index == first->poses.index + 1;
    return is_pair ? &*next : nullptr;
  }
  return partner_by_progress(first, stations, rule, tolerance);
}

RelativeDifference difference(const PosePair& first, const PosePair& second) {
  const Pose2 true_motion = first.truth.inverse() * second.truth;
  const Pose2 estimated_motion = first.estimate.inverse() * second.estimate;
  const Pose2 error = true_motion.inverse() * estimated_motion;
  return {first.stamp, error.translation().norm(), std::abs(error.theta)};
}

template <typename ValueOf>
std::optional<ErrorStatistics> statistics_of(const std::vector<RelativeDifference>& differences,
                                             ValueOf&& value_of) {
  if (differences.empty()) {
    return std::nullopt;
  }
  std::vector<double> values;
  values.reserve(differences.size());
  for (const RelativeDifference& one : differences) {
    values.push_back(value_of(one));
  }
  return summarize_errors(values);
}

RelativePoseErrorMeasure measure(const Stations& stations, const PairRule& rule, double tolerance) {
  RelativePoseErrorMeasure result;
  result.rule = rule;
  for (auto first = stations.begin(); first != stations.end(); ++first) {
    if (const Station* second = partner(first, stations, rule, tolerance)) {
      result.differences.push_back(difference(first->poses, second->poses));
    }
  }
  result.translation =
      statistics_of(result.differences, [](const auto& d) { return d.translation; });
  result.rotation = statistics_of(result.differences, [](const auto& d) { return d.rotation; });
  return result;
}

void check(const RelativePoseErrorOptions& options) {
  const bool is_bad_step = std::any_of(options.rules.begin(), options.rules.end(),
                                       [](const PairRule& rule) { return !(rule.step > 0.0); });
  if (is_bad_step || !(options.max_gap > 0.0) || !(options.tolerance >= 0.0)) {
    throw std::invalid_argument("options of the relative pose error that are not allowed");
  }
}

}  // namespace

RelativePoseError relative_pose_error(const Trajectory& estimate, const Trajectory& truth,
                                      const RelativePoseErrorOptions& options) {
  check(options);
  const std::vector<PosePair> pairs = associate_some(estimate, truth, options.max_gap);
  const Stations stations = stations_of(pairs, truth, options.max_gap);
  RelativePoseError result;
  result.without_truth = estimate.size() - pairs.size();
  for (const PairRule& rule : options.rules) {
    result.measures.push_back(measure(stations, rule, options.tolerance));
  }
  if (std::all_of(result.measures.begin(), result.measures.end(),
                  [](const RelativePoseErrorMeasure& one) { return one.differences.empty(); })) {
    throw EvaluationError(
        "no two poses of the estimate make a pair: " + std::to_string(pairs.size()) + " of " +
        std::to_string(estimate.size()) + " poses have truth");
  }
  return result;
}

}  // namespace matchbox_slam
