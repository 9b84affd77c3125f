#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/Imu.h>

#include <Eigen/Geometry>
#include <optional>
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

/// Whether an IMU says that it measures no orientation: by REP-145 a covariance of -1, or a
/// quaternion that was never set.
[[nodiscard]] bool has_no_orientation(const sensor_msgs::Imu& message);

/// The heading by an IMU that measures rates of turn alone: what of them is about the vertical,
/// added up from message to message. It drifts; from scan to scan that is little.
class GyroHeading {
 public:
  /// Why a message tells no rate of turn, for people; empty when it does.
  [[nodiscard]] static std::string find_defect(const sensor_msgs::Imu& message);

  /// Takes a message without defect that is newer than the one before; others change nothing.
  /// @param base_from_imu  how it is mounted.
  /// @return the link of its stamp, as of `heading_link`; none: it is not newer.
  [[nodiscard]] std::optional<geometry_msgs::TransformStamped> add(
      const sensor_msgs::Imu& message, const Eigen::Matrix3d& base_from_imu);

  /// Begins anew.
  void clear() { newest_.reset(); }

 private:
  struct Reading {
    ros::Time stamp;
    double rate = 0.0;  ///< [rad/s] about the vertical
  };
  std::optional<Reading> newest_;
  double heading_ = 0.0;  ///< [rad]
};

}  // namespace matchbox_slam
