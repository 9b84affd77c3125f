#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/Imu.h>

#include <Eigen/Geometry>
#include <string>

namespace matchbox_slam {

/// The frame in which an IMU's orientation turns, as the links of `heading_link` name it.
constexpr const char* kImuHeadingFrame = "imu_heading";

/// Why an IMU's message tells no orientation, for people; empty when it does.
[[nodiscard]] std::string find_defect(const sensor_msgs::Imu& message);

/// The orientation of the base by an IMU, as a link of tf from the base down to kImuHeadingFrame,
/// so that a base with another parent in tf does not get a second one. Positions are 0.
/// @param message        without defect.
/// @param imu_from_base  how the IMU is mounted; its position does not matter.
[[nodiscard]] geometry_msgs::TransformStamped heading_link(const sensor_msgs::Imu& message,
                                                           const Eigen::Isometry3d& imu_from_base,
                                                           const std::string& base_frame);

}  // namespace matchbox_slam
