#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// Odometry around one scan.
struct ScanOdometry {
  Pose2 odom_from_base;            ///< at the scan's stamp, the time of its first beam
  Pose2 odom_from_base_last_beam;  ///< at the time of its last beam
  bool is_heading_only = false;    ///< as of an IMU: the positions mean nothing
};

/// One scan with all that is known about it when it is processed.
struct ScanInput {
  LaserScan scan;
  /// At the scan's stamp. The base's z axis is upright: where the robot leans, so does this.
  Eigen::Isometry3d base_from_laser = Eigen::Isometry3d::Identity();
  std::optional<ScanOdometry> odometry;  ///< none: the engine goes by constant velocity
  int laser = 0;                         ///< which of the robot's lasers, where it has several
  /// Of the laser, from the first beam to the last, besides the base's motion in the plane: the
  /// robot rocks, or the laser is tilted on it.
  Eigen::Isometry3d laser_motion = Eigen::Isometry3d::Identity();
};

}  // namespace matchbox_slam
