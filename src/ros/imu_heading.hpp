#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/Imu.h>

#include <string>

namespace matchbox_slam {

/// The frame in which an IMU's orientation turns, as the links of `heading_link` name it.
constexpr const char* kImuHeadingFrame = "imu_heading";

/// Why an IMU's message tells no orientation, for people; empty when it does.
[[nodiscard]] std::string find_defect(const sensor_msgs::Imu& message);

/// The orientation of an IMU as a link of tf from its frame down to kImuHeadingFrame, so that one
/// that has another parent in tf does not get a second one. The base's orientation follows by tf,
/// however the IMU is mounted; positions in that frame mean nothing.
/// @param message  without defect.
[[nodiscard]] geometry_msgs::TransformStamped heading_link(const sensor_msgs::Imu& message);

}  // namespace matchbox_slam
