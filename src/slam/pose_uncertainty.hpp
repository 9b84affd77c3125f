#pragma once

#include <Eigen/Core>

#include "matchbox_slam/slam/scan_outcome.hpp"
#include "slam/map_components.hpp"

namespace matchbox_slam {

// What is known of a pose beside what its match says: covariances over (x, y, theta) in the map
// frame.

/// What is told of a scan's pose, with how well it is known where the map lies there, and that a
/// lost robot may be anywhere in it.
/// @param maps  whether the map grows; else it is what it is.
[[nodiscard]] Eigen::Matrix3d reported_covariance(const ScanOutcome& outcome,
                                                  const MapComponents& components, bool maps);

/// How well it is known where a robot is as seen from what it has just drawn, which lies as wrong
/// as the robot is: in a corridor that does not hold it the way since then counts alone. Else the
/// next matches may slide along it by all that has come together on its way.
/// @param covariance  of the pose that it was drawn from.
[[nodiscard]] Eigen::Matrix3d beside_drawn(const Eigen::Matrix3d& covariance);

}  // namespace matchbox_slam
