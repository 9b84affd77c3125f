#include "ros/odometry_message.hpp"

#include "ros/message_conversion.hpp"

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

}  // namespace matchbox_slam
