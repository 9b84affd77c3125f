#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include <string>

#include "matchbox_slam/slam/laser_odometry.hpp"

namespace matchbox_slam {

/// Laser odometry as a message: the pose in `odom_frame`, the twist in `base_frame`. Both
/// covariances are positive definite; height, roll and pitch, of which nothing is measured, have a
/// variance of kUnknownVariance.
/// @param stamp  of the scan.
[[nodiscard]] nav_msgs::Odometry to_message(const LaserOdometryOutcome& outcome,
                                            const ros::Time& stamp, const std::string& odom_frame,
                                            const std::string& base_frame);

}  // namespace matchbox_slam
