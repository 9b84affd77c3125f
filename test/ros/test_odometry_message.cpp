#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"
#include "ros/odometry_message.hpp"

namespace matchbox_slam {
namespace {

TEST(OdometryMessage, HasPoseAndTwistWithCovariances) {
  LaserOdometryOutcome outcome;
  outcome.odom_from_base = {1.0, 2.0, 0.5 * kPi};
  outcome.covariance << 4.0, 0.1, 0.2, 0.1, 5.0, 0.3, 0.2, 0.3, 6.0;
  outcome.velocity = {0.5, -0.1, 0.2};
  outcome.velocity_covariance = Eigen::Vector3d(7.0, 8.0, 9.0).asDiagonal();
  const nav_msgs::Odometry message = to_message(outcome, ros::Time(3.0), "odom", "base_link");
  EXPECT_EQ(message.header.stamp, ros::Time(3.0));
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.pose.pose.position.y, 2.0);
  EXPECT_NEAR(message.pose.pose.orientation.z, std::sqrt(0.5), 1e-12);
  EXPECT_EQ(message.pose.covariance[0], 4.0);
  EXPECT_EQ(message.pose.covariance[1], 0.1);
  EXPECT_EQ(message.pose.covariance[5], 0.2);
  EXPECT_EQ(message.pose.covariance[35], 6.0);
  EXPECT_EQ(message.twist.twist.linear.x, 0.5);
  EXPECT_EQ(message.twist.twist.linear.y, -0.1);
  EXPECT_EQ(message.twist.twist.angular.z, 0.2);
  EXPECT_EQ(message.twist.covariance[7], 8.0);
  EXPECT_EQ(message.twist.covariance[35], 9.0);
  for (const std::size_t axis : {2U, 3U, 4U}) {
    EXPECT_EQ(message.pose.covariance[7 * axis], kUnknownVariance);
    EXPECT_EQ(message.twist.covariance[7 * axis], kUnknownVariance);
  }
}

}  // namespace
}  // namespace matchbox_slam
