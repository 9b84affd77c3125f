#include "ros/imu_heading.hpp"

#include <fmt/core.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"
#include "ros/message_conversion.hpp"
#include "run/frames.hpp"

namespace matchbox_slam {

namespace {

Eigen::Quaterniond orientation_of(const sensor_msgs::Imu& message) {
  Eigen::Quaterniond orientation;
  tf2::fromMsg(message.orientation, orientation);
  return orientation;
}

geometry_msgs::TransformStamped link_of(const sensor_msgs::Imu& message,
                                        const Eigen::Quaterniond& heading_from_imu) {
  geometry_msgs::TransformStamped link;
  link.header = message.header;
  link.child_frame_id = kImuHeadingFrame;
  link.transform.rotation = tf2::toMsg(heading_from_imu.normalized().conjugate());
  return link;
}

/// What is wrong with whose and when it is; empty: nothing.
std::string find_defect_of_header(const std_msgs::Header& header) {
  if (header.stamp.isZero() || !is_usable(header.stamp)) {
    return header.stamp.isZero() ? "its stamp is 0" : "its stamp is none";
  }
  if (without_leading_slash(header.frame_id).empty()) {
    return "it does not name its frame";
  }
  return {};
}

}  // namespace

std::string find_defect(const sensor_msgs::Imu& message) {
  if (std::string defect = find_defect_of_header(message.header); !defect.empty()) {
    return defect;
  }
  if (message.orientation_covariance[0] == -1.0) {
    return "orientation_covariance[0] is -1, which says that it measures no orientation";
  }
  constexpr double kNormTolerance = 0.05;
  const double norm = orientation_of(message).norm();
  if (!(std::abs(norm - 1.0) <= kNormTolerance)) {
    return fmt::format("its orientation is a quaternion of length {:f} and not 1", norm);
  }
  return {};
}

geometry_msgs::TransformStamped heading_link(const sensor_msgs::Imu& message) {
  return link_of(message, orientation_of(message));
}

bool has_no_orientation(const sensor_msgs::Imu& message) {
  return message.orientation_covariance[0] == -1.0 || orientation_of(message).norm() == 0.0;
}

std::string GyroHeading::find_defect(const sensor_msgs::Imu& message) {
  if (std::string defect = find_defect_of_header(message.header); !defect.empty()) {
    return defect;
  }
  if (message.angular_velocity_covariance[0] == -1.0) {
    return "it measures neither orientation nor rate of turn: both covariances begin with -1";
  }
  if (!is_usable(message.angular_velocity)) {
    return "its rate of turn is no number";
  }
  return {};
}

std::optional<geometry_msgs::TransformStamped> GyroHeading::add(
    const sensor_msgs::Imu& message, const Eigen::Matrix3d& base_from_imu) {
  const geometry_msgs::Vector3& rate = message.angular_velocity;
  const Reading reading{message.header.stamp,
                        base_from_imu.row(2).dot(Eigen::Vector3d(rate.x, rate.y, rate.z))};
  if (newest_ && !(newest_->stamp < reading.stamp)) {
    return std::nullopt;
  }
  const double passed = newest_ ? seconds_between(newest_->stamp, reading.stamp) : 0.0;
  heading_ = wrap_angle(heading_ + 0.5 * passed * (reading.rate + (newest_ ? newest_->rate : 0.0)));
  newest_ = reading;
  const Eigen::AngleAxisd turned(heading_, Eigen::Vector3d::UnitZ());
  return link_of(message, Eigen::Quaterniond(turned.toRotationMatrix() * base_from_imu));
}

}  // namespace matchbox_slam
