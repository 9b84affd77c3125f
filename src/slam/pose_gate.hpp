#pragma once

#include <cmath>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// Whether two poses are nearer to each other than that: [m] and [rad]. (Places on a lattice lie as
/// far apart as its step is, which is not nearer.)
[[nodiscard]] inline bool are_near(const Pose2& a, const Pose2& b, double distance, double angle) {
  const Eigen::Vector3d apart = difference(a, b);
  return apart.head<2>().norm() < distance && std::abs(apart.z()) < angle;
}

}  // namespace matchbox_slam
