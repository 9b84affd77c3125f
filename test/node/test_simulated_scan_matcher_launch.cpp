// Of simulated_scan_matcher.launch: it has been started; this compares what comes out with the
// truth, and clears up.

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <cmath>
#include <filesystem>

#include "io/tum.hpp"
#include "node/slam_listener.hpp"
#include "ros/message_conversion.hpp"

namespace matchbox_slam {
namespace {

TEST(SimulatedScanMatcherLaunch, SimulatesAndFollowsTheRobot) {
  constexpr std::size_t kScans = 201;  // 10 s at 20 Hz
  SlamListener listener;
  std::vector<nav_msgs::Odometry> odometry;
  ros::NodeHandle node;
  const ros::Subscriber subscriber = node.subscribe<nav_msgs::Odometry>(
      "scan_odom", 1000,
      [&](const nav_msgs::Odometry::ConstPtr& message) { odometry.push_back(*message); });
  EXPECT_TRUE(listener.wait_until([&] { return odometry.size() == kScans; }, 90.0))
      << odometry.size() << " of " << kScans << " scans were matched";
  const auto bag = ros::param::param<std::string>("~bag", "");
  const Trajectory truth = read_tum(bag + ".truth.tum");
  ASSERT_GE(odometry.size(), 2U);
  ASSERT_GE(truth.size(), 2U);
  const Pose2 moved =
      to_pose2(odometry.front().pose.pose).inverse() * to_pose2(odometry.back().pose.pose);
  const Pose2 error =
      moved.inverse() * (truth.poses().front().pose.inverse() * truth.poses().back().pose);
  EXPECT_LT(std::hypot(error.x, error.y), 0.01);
  EXPECT_LT(std::abs(error.theta), 0.003);
  EXPECT_TRUE(
      listener.transforms.lookup("scan_odom", "base_footprint", odometry.back().header.stamp));
  EXPECT_TRUE(std::filesystem::remove(bag)) << bag;
  EXPECT_TRUE(std::filesystem::remove(bag + ".truth.tum")) << bag;
}

}  // namespace
}  // namespace matchbox_slam
