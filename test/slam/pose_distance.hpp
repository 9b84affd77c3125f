#pragma once

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// From one base to the other [m].
[[nodiscard]] inline double distance(const Pose2& a, const Pose2& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace matchbox_slam
