#include "ros/odometry_message.hpp"

#include <fmt/core.h>

#include "ros/message_conversion.hpp"
#include "run/frames.hpp"

namespace matchbox_slam {

namespace {

template <typename Covariance>
void mark_unknown_axes(Covariance& covariance) {
  for (const std::size_t axis : {2U, 3U, 4U}) {  // z, roll and pitch
    covariance[7 * axis] = kUnknownVariance;
  }
}

}  // namespace

nav_msgs::Odometry to_message(const LaserOdometryOutcome& outcome, const ros::Time& stamp,
                              const std::string& odom_frame, const std::string& base_frame) {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = odom_frame;
  message.child_frame_id = base_frame;
  message.pose = to_pose_message(outcome.odom_from_base, outcome.covariance);
  message.twist.twist.linear.x = outcome.velocity.x();
  message.twist.twist.linear.y = outcome.velocity.y();
  message.twist.twist.angular.z = outcome.velocity.z();
  message.twist.covariance = to_pose_message(Pose2{}, outcome.velocity_covariance).covariance;
  mark_unknown_axes(message.pose.covariance);
  mark_unknown_axes(message.twist.covariance);
  return message;
}

std::string find_defect(const nav_msgs::Odometry& message, const std::string& odom_frame) {
  const std::string frame = without_leading_slash(message.header.frame_id);
  const geometry_msgs::Pose& pose = message.pose.pose;
  geometry_msgs::Vector3 position;
  position.x = pose.position.x;
  position.y = pose.position.y;
  position.z = pose.position.z;
  if (message.header.stamp.isZero() || !is_usable(message.header.stamp)) {
    return "its stamp is none";
  }
  if (!is_usable(position)) {
    return "its position is no number";
  }
  if (!is_rotation(pose.orientation)) {
    return "its orientation is no quaternion of length 1";
  }
  if (!frame.empty() && frame != odom_frame) {
    return fmt::format("its frame is '{}' and odom_frame is '{}': they have to be the same", frame,
                       odom_frame);
  }
  return {};
}

geometry_msgs::TransformStamped odometry_link(const nav_msgs::Odometry& message,
                                              const std::string& odom_frame) {
  geometry_msgs::TransformStamped link;
  link.header.stamp = message.header.stamp;
  link.header.frame_id = odom_frame;
  link.child_frame_id = kOdometryChildFrame;
  link.transform.translation.x = message.pose.pose.position.x;
  link.transform.translation.y = message.pose.pose.position.y;
  link.transform.translation.z = message.pose.pose.position.z;
  link.transform.rotation = message.pose.pose.orientation;
  return link;
}

}  // namespace matchbox_slam
