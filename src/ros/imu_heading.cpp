#include "ros/imu_heading.hpp"

#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "run/frames.hpp"

namespace matchbox_slam {

namespace {

Eigen::Quaterniond orientation_of(const sensor_msgs::Imu& message) {
  Eigen::Quaterniond orientation;
  tf2::fromMsg(message.orientation, orientation);
  return orientation;
}

}  // namespace

std::string find_defect(const sensor_msgs::Imu& message) {
  if (message.header.stamp.isZero()) {
    return "its stamp is 0";
  }
  if (without_leading_slash(message.header.frame_id).empty()) {
    return "it does not name its frame";
  }
  if (message.orientation_covariance[0] == -1.0) {
    return "orientation_covariance[0] is -1, which says that it measures no orientation";
  }
  constexpr double kNormTolerance = 0.05;
  const double norm = orientation_of(message).norm();
  if (!(std::abs(norm - 1.0) <= kNormTolerance)) {
    return "its orientation is a quaternion of length " + std::to_string(norm) + " and not 1";
  }
  return {};
}

geometry_msgs::TransformStamped heading_link(const sensor_msgs::Imu& message) {
  geometry_msgs::TransformStamped link;
  link.header = message.header;
  link.child_frame_id = kImuHeadingFrame;
  link.transform.rotation =
      tf2::toMsg(orientation_of(message).normalized().conjugate());  // the IMU from it
  return link;
}

}  // namespace matchbox_slam
