#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "tools/map_shades.hpp"

namespace matchbox_slam {

/// How a run stood at one moment; all in the frame of the map.
struct MovieFrame {
  using Point = Eigen::Vector2f;  ///< [m]

  double time = 0.0;  ///< since the first scan [s]
  TrackingState state = TrackingState::kTracking;
  int level = 0;  ///< of the map's cells, see MovieMap
  MapShades map;
  std::vector<std::vector<Point>> path;  ///< of the base; broken where the robot was lost
  std::vector<std::pair<Point, Point>> loops;
  std::optional<Pose2> robot;        ///< none: lost
  std::vector<WeightedPose> others;  ///< where else it may have been since the frame before
};

}  // namespace matchbox_slam
