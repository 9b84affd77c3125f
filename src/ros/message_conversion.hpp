#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Transform.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include <Eigen/Core>
#include <string>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// What makes a scan unusable as a whole, for people; empty when nothing does. Single readings may
/// be anything; what is judged here is the geometry and the stamp.
[[nodiscard]] std::string find_defect(const sensor_msgs::LaserScan& message);

/// The same of a pose from elsewhere, such as initialpose; only its part in the plane is judged.
[[nodiscard]] std::string find_defect(const geometry_msgs::PoseWithCovariance& message);

/// Seconds from one time to another; the difference of two ros::Time throws beyond 68 years.
[[nodiscard]] double seconds_between(const ros::Time& begin, const ros::Time& end);

/// Whether one can reckon with a stamp: it is not at the end of what ros::Time holds, beyond which
/// that throws, and its nanoseconds are less than a second, which messages do not guarantee.
[[nodiscard]] bool is_usable(const ros::Time& stamp);

/// Whether a position is made of numbers so small that sums of several are numbers, too.
[[nodiscard]] bool is_usable(const geometry_msgs::Vector3& position);

/// Whether tf2 takes a frame by this name, which has lost its one leading slash already.
[[nodiscard]] inline bool is_frame_id(const std::string& name) {
  return !name.empty() && name.front() != '/';
}

/// Whether a quaternion has the length 1, or nearly.
[[nodiscard]] bool is_rotation(const geometry_msgs::Quaternion& rotation);

/// A scan without defect as the core takes it. Beams are counted from the ranges, never from
/// `angle_max`, which drivers round in various ways.
[[nodiscard]] LaserScan to_laser_scan(const sensor_msgs::LaserScan& message);

/// The known part of a grid, -1 where nothing was observed, else 0...100.
/// @param stamp  when the map was as it is.
[[nodiscard]] nav_msgs::OccupancyGrid to_message(const OccupancyGrid& grid,
                                                 const std::string& map_frame,
                                                 const ros::Time& stamp);

[[nodiscard]] geometry_msgs::Pose to_pose_message(const Pose2& pose);
[[nodiscard]] geometry_msgs::Transform to_transform_message(const Pose2& pose);

/// @param covariance  over (x, y, theta). Height, roll and pitch are not estimated: they are 0, and
///                    so are their variances, as REP-103's 6 x 6 row-major order has them.
[[nodiscard]] geometry_msgs::PoseWithCovariance to_pose_message(const Pose2& pose,
                                                                const Eigen::Matrix3d& covariance);

[[nodiscard]] Pose2 to_pose2(const geometry_msgs::Pose& pose);

/// Covariance over (x, y, theta) of a pose in space.
[[nodiscard]] Eigen::Matrix3d plane_covariance(const geometry_msgs::PoseWithCovariance& pose);

}  // namespace matchbox_slam
