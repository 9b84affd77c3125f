#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include <string>

#include "matchbox_slam/odometry/laser_odometry.hpp"

namespace matchbox_slam {

/// Laser odometry as a message: the pose in `odom_frame`, the twist in `base_frame`. Both
/// covariances are positive definite; height, roll and pitch, of which nothing is measured, have a
/// variance of kUnknownVariance.
/// @param stamp  of the scan.
[[nodiscard]] nav_msgs::Odometry to_message(const LaserOdometryOutcome& outcome,
                                            const ros::Time& stamp, const std::string& odom_frame,
                                            const std::string& base_frame);

/// The frame of an Odometry message's pose as the links of `odometry_link` name it: a frame of its
/// own, since the one that the message names may hang elsewhere in tf already.
constexpr const char* kOdometryChildFrame = "odometry_child";

/// What makes a message from elsewhere unusable as odometry, for people; empty: nothing. A frame
/// that is left empty is the one asked for.
/// @param odom_frame  in which the odometry is wanted, without leading slash.
[[nodiscard]] std::string find_defect(const nav_msgs::Odometry& message,
                                      const std::string& odom_frame);

/// The pose of a message without defect as a link of tf from `odom_frame` down to
/// kOdometryChildFrame.
[[nodiscard]] geometry_msgs::TransformStamped odometry_link(const nav_msgs::Odometry& message,
                                                            const std::string& odom_frame);

}  // namespace matchbox_slam
