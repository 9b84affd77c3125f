#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// Where the robot was at one stamp, as seen from where it was at another; verified by people.
struct Relation {
  double first_stamp = 0.0;   ///< [s]
  double second_stamp = 0.0;  ///< [s], before or after the first
  Pose2 first_from_second;
};

struct RelationErrorOptions {
  double max_distance = 0.5;  ///< [s], > 0; farther from any pose a relation's stamp is not used
};

/// Mean, standard deviation (of the population) and largest.
struct ErrorSpread {
  double mean = 0.0;
  double deviation = 0.0;
  double max = 0.0;
};

/// One for each relation that could be used.
struct RelationDifference {
  double translation = 0.0;  ///< [m]
  double rotation = 0.0;     ///< [rad]
};

/// How far the relative poses of an estimate are from known ones.
struct RelationError {
  std::vector<RelationDifference> differences;  ///< in the order of the relations
  std::size_t unusable = 0;  ///< a stamp without a pose (of the odometry, if there is any) nearby
  std::size_t extrapolated = 0;  ///< of the used: a stamp is outside the estimate, beyond what is
                                 ///< nearby; raw odometry alone tells the pose there
  ErrorSpread translation;       ///< [m]
  ErrorSpread translation_squared;  ///< [m^2]
  ErrorSpread rotation;             ///< [rad]
  ErrorSpread rotation_squared;     ///< [rad^2]
};

/// Compares an estimate with relations (Kümmerle et al., "On measuring the accuracy of SLAM
/// algorithms", Autonomous Robots 2009): the difference of each is
/// `first_from_second^-1 * (estimate(first)^-1 * estimate(second))`.
///
/// The estimate's pose at a stamp between two of its poses: raw odometry carries both of them to
/// the stamp, and what comes out is blended by nearness in time, on the straight line and along the
/// shorter arc. Before its first and after its last pose that one alone is carried. Without
/// odometry the estimate is interpolated, and stands still outside its range.
///
/// A relation is usable when odometry has a pose within `max_distance` of both its stamps; without
/// odometry, when the estimate has.
///
/// Throws EvaluationError when the estimate, the odometry or the relations are empty, and when no
/// relation is usable: the text then names the time ranges. Throws std::invalid_argument for
/// options that are not allowed.
[[nodiscard]] RelationError relation_error(const Trajectory& estimate,
                                           const std::vector<Relation>& relations,
                                           const std::optional<Trajectory>& odometry = {},
                                           const RelationErrorOptions& options = {});

}  // namespace matchbox_slam
