#include "evaluation/relation_error.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>

#include "common/number_text.hpp"

namespace matchbox_slam {
namespace {

using Poses = std::vector<StampedPose2>;

Poses::const_iterator first_not_before(const Poses& poses, double stamp) {
  return std::lower_bound(
      poses.begin(), poses.end(), stamp,
      [](const StampedPose2& stamped, double time) { return stamped.stamp < time; });
}

double distance_to_nearest(const Poses& poses, double stamp) {
  const auto after = first_not_before(poses, stamp);
  double distance = std::numeric_limits<double>::infinity();
  if (after != poses.end()) {
    distance = after->stamp - stamp;
  }
  if (after != poses.begin()) {
    distance = std::min(distance, stamp - std::prev(after)->stamp);
  }
  return distance;
}

/// Interpolated; outside the range the pose at its end.
Pose2 clamped_pose_at(const Trajectory& trajectory, double stamp) {
  const double inside =
      std::clamp(stamp, trajectory.poses().front().stamp, trajectory.poses().back().stamp);
  return trajectory.at(inside, std::numeric_limits<double>::infinity()).value();
}

/// A pose of the estimate, moved on by what odometry says happened between it and `stamp`.
Pose2 carried(const StampedPose2& estimated, const Trajectory& odometry, double stamp) {
  return estimated.pose * clamped_pose_at(odometry, estimated.stamp).inverse() *
         clamped_pose_at(odometry, stamp);
}

Pose2 pose_at(const Trajectory& estimate, const Trajectory& odometry, double stamp) {
  const auto after = first_not_before(estimate.poses(), stamp);
  if (after == estimate.poses().begin()) {
    return carried(*after, odometry, stamp);
  }
  const auto before = std::prev(after);
  if (after == estimate.poses().end()) {
    return carried(*before, odometry, stamp);
  }
  return interpolate(carried(*before, odometry, stamp), carried(*after, odometry, stamp),
                     (stamp - before->stamp) / (after->stamp - before->stamp));
}

template <typename ValueOf>
ErrorSpread spread_of(const std::vector<RelationDifference>& differences, ValueOf&& value_of) {
  ErrorSpread spread;
  const auto count = static_cast<double>(differences.size());
  for (const RelationDifference& difference : differences) {
    spread.mean += value_of(difference) / count;
    spread.max = std::max(spread.max, value_of(difference));
  }
  double variance = 0.0;
  for (const RelationDifference& difference : differences) {
    variance += std::pow(value_of(difference) - spread.mean, 2) / count;
  }
  spread.deviation = std::sqrt(variance);
  return spread;
}

void summarize(RelationError& error) {
  const auto squared = [](double value) { return value * value; };
  const auto& differences = error.differences;
  error.translation = spread_of(differences, [](const auto& d) { return d.translation; });
  error.translation_squared =
      spread_of(differences, [&](const auto& d) { return squared(d.translation); });
  error.rotation = spread_of(differences, [](const auto& d) { return d.rotation; });
  error.rotation_squared =
      spread_of(differences, [&](const auto& d) { return squared(d.rotation); });
}

void check(const Trajectory& estimate, const std::vector<Relation>& relations,
           const std::optional<Trajectory>& odometry, const RelationErrorOptions& options) {
  if (!(options.max_distance > 0.0)) {
    throw std::invalid_argument("the greatest distance of a pose from a stamp has to be above 0");
  }
  if (estimate.empty()) {
    throw EvaluationError("the estimate holds no poses");
  }
  if (odometry && odometry->empty()) {
    throw EvaluationError("the odometry holds no poses");
  }
  if (relations.empty()) {
    throw EvaluationError("there are no relations to compare with");
  }
}

[[noreturn]] void throw_none_usable(const std::vector<Relation>& relations, const Trajectory& poses,
                                    bool is_odometry, double max_distance) {
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const Relation& relation : relations) {
    first = std::min({first, relation.first_stamp, relation.second_stamp});
    last = std::max({last, relation.first_stamp, relation.second_stamp});
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "no relation is usable: none has a pose of the "
       << (is_odometry ? "odometry" : "estimate") << " within " << max_distance
       << " s of both its stamps; the relations are from " << fixed_text(first, 3) << " to "
       << fixed_text(last, 3) << " s, the " << (is_odometry ? "odometry" : "estimate") << " from "
       << time_range_text(poses) << "; are both in the same clock?";
  throw EvaluationError(text.str());
}

}  // namespace

RelationError relation_error(const Trajectory& estimate, const std::vector<Relation>& relations,
                             const std::optional<Trajectory>& odometry,
                             const RelationErrorOptions& options) {
  check(estimate, relations, odometry, options);
  const Trajectory& nearby = odometry ? *odometry : estimate;
  const auto estimate_at = [&](double stamp) {
    return odometry ? pose_at(estimate, *odometry, stamp) : clamped_pose_at(estimate, stamp);
  };
  const auto is_near = [&](const Trajectory& poses, double stamp) {
    return distance_to_nearest(poses.poses(), stamp) <= options.max_distance;
  };
  const auto is_outside = [&](double stamp) {
    return stamp < estimate.poses().front().stamp - options.max_distance ||
           stamp > estimate.poses().back().stamp + options.max_distance;
  };
  RelationError error;
  for (const Relation& relation : relations) {
    const double first = relation.first_stamp;
    const double second = relation.second_stamp;
    if (!is_near(nearby, first) || !is_near(nearby, second)) {
      ++error.unusable;
      continue;
    }
    error.extrapolated += is_outside(first) || is_outside(second) ? 1 : 0;
    const Pose2 difference =
        relation.first_from_second.inverse() * (estimate_at(first).inverse() * estimate_at(second));
    error.differences.push_back({difference.translation().norm(), std::abs(difference.theta)});
  }
  if (error.differences.empty()) {
    throw_none_usable(relations, nearby, odometry.has_value(), options.max_distance);
  }
  summarize(error);
  return error;
}

}  // namespace matchbox_slam
