#pragma once

#include <vector>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// The same way elsewhere: each pose as seen from a frame that the motion leads to.
[[nodiscard]] inline Trajectory moved(const Trajectory& trajectory, const Pose2& motion) {
  std::vector<StampedPose2> poses = trajectory.poses();
  for (StampedPose2& stamped : poses) {
    stamped.pose = motion * stamped.pose;
  }
  return Trajectory(poses);
}

}  // namespace matchbox_slam
