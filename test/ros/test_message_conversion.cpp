#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/error_text.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(MessageConversion, CountsBeamsFromTheRanges) {
  sensor_msgs::LaserScan message = make_scan(12.5);
  message.angle_max = 17.0F;  // wrong, as some drivers have it
  message.time_increment = 1e-4F;
  const LaserScan scan = to_laser_scan(message);
  EXPECT_EQ(scan.ranges, message.ranges);
  EXPECT_DOUBLE_EQ(scan.stamp, 12.5);
  EXPECT_DOUBLE_EQ(scan.angle_min, -2.0);
  EXPECT_NEAR(scan.duration(), 89e-4, 1e-9);
  EXPECT_EQ(find_defect(message), "");
}

TEST(MessageConversion, SingleReadingsMayBeAnything) {
  sensor_msgs::LaserScan message = make_scan(1.0);
  message.ranges = {kNaN, kInfinity, -kInfinity, 0.0F, -1.0F};
  EXPECT_EQ(find_defect(message), "");
}

TEST(MessageConversion, ASingleBeamNeedsNoIncrement) {
  sensor_msgs::LaserScan message = make_scan(1.0, "laser", 1);
  message.angle_increment = 0.0F;
  EXPECT_EQ(find_defect(message), "");
}

TEST(MessageConversion, NegativeIncrementIsAScan) {
  sensor_msgs::LaserScan message = make_scan(1.0);
  message.angle_increment = -0.01F;
  EXPECT_EQ(find_defect(message), "");
}

TEST(MessageConversion, FindsDefects) {
  const auto defect = [](auto&& spoil) {
    sensor_msgs::LaserScan message = make_scan(1.0);
    spoil(message);
    return find_defect(message);
  };
  using Scan = sensor_msgs::LaserScan;
  EXPECT_EQ(defect([](Scan& m) { m.ranges.clear(); }), "it has no ranges");
  EXPECT_TRUE(contains(defect([](Scan& m) { m.header.stamp = ros::Time(); }), "stamp"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.header.stamp = ros::TIME_MAX; }), "stamp"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.header.frame_id = "/"; }), "frame_id"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.angle_min = kNaN; }), "angle_min"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.angle_increment = kInfinity; }), "not a number"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.angle_increment = 0.0F; }), "angle_increment is 0"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.range_max = kNaN; }), "range_max"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.range_min = -1.0F; }), "range_min"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.range_max = 0.05F; }), "no valid range"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.time_increment = kNaN; }), "time_increment"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.time_increment = -0.1F; }), "time_increment"));
  EXPECT_TRUE(contains(defect([](Scan& m) { m.time_increment = 10.0F; }), "time_increment"));
}

TEST(MessageConversion, WritesTheKnownPartOfAMap) {
  OccupancyGrid grid(0.1);
  grid.blend({-3, 2}, 1.0, 1.0);
  grid.blend({-1, 3}, 0.0, 1.0);
  const nav_msgs::OccupancyGrid message = to_message(grid, "map", ros::Time(7.0));
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.header.stamp, ros::Time(7.0));
  EXPECT_EQ(message.info.map_load_time, ros::Time(7.0));
  EXPECT_FLOAT_EQ(message.info.resolution, 0.1F);
  EXPECT_EQ(message.info.width, 3U);
  EXPECT_EQ(message.info.height, 2U);
  EXPECT_NEAR(message.info.origin.position.x, -0.3, 1e-12);
  EXPECT_NEAR(message.info.origin.position.y, 0.2, 1e-12);
  EXPECT_DOUBLE_EQ(message.info.origin.orientation.w, 1.0);
  EXPECT_EQ(message.data, (std::vector<std::int8_t>{100, -1, -1, -1, -1, 0}));
}

TEST(MessageConversion, AnEmptyMapIsAMessageToo) {
  const nav_msgs::OccupancyGrid message = to_message(OccupancyGrid(0.05), "map", ros::Time(1.0));
  EXPECT_EQ(message.info.width, 0U);
  EXPECT_TRUE(message.data.empty());
  EXPECT_DOUBLE_EQ(message.info.origin.orientation.w, 1.0);
}

TEST(MessageConversion, CovarianceGoesToItsPlacesAmongSix) {
  Eigen::Matrix3d covariance;
  covariance << 1.0, 2.0, 3.0,  //
      4.0, 5.0, 6.0,            //
      7.0, 8.0, 9.0;
  const auto message = to_pose_message(Pose2{1.0, 2.0, 0.5}, covariance);
  const std::vector<std::size_t> places = {0, 1, 5, 6, 7, 11, 30, 31, 35};
  double sum = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    EXPECT_DOUBLE_EQ(message.covariance[places[k]], static_cast<double>(k + 1));
  }
  for (const double entry : message.covariance) {
    sum += entry;
  }
  EXPECT_DOUBLE_EQ(sum, 45.0);
  EXPECT_EQ(plane_covariance(message), covariance);
}

TEST(MessageConversion, FindsStampsAndScansThatNobodyCanReckonWith) {
  sensor_msgs::LaserScan scan = make_scan(1000.0);
  scan.header.stamp.nsec = 1'000'000'000U;  // as no constructor makes it, but a message may hold
  EXPECT_TRUE(contains(find_defect(scan), "1000000000 ns is none")) << find_defect(scan);
  scan = make_scan(1000.0, "laser", 100'000);
  EXPECT_EQ(find_defect(scan), "");
  scan.ranges.push_back(1.0F);
  EXPECT_EQ(find_defect(scan), "it has 100001 ranges; allowed: up to 100000");
}

TEST(MessageConversion, FindsPosesThatAreNone) {
  const auto defect = [](auto&& change) {
    auto message = to_pose_message(Pose2{1.0, 2.0, 0.5}, Eigen::Matrix3d::Identity());
    change(message);
    return find_defect(message);
  };
  EXPECT_EQ(defect([](auto& /*message*/) {}), "");
  EXPECT_EQ(defect([](auto& message) { message.covariance.fill(0.0); }), "");
  EXPECT_TRUE(contains(defect([](auto& message) { message.pose.position.x = 1e9; }), "position"));
  EXPECT_TRUE(
      contains(defect([](auto& message) { message.pose.position.y = std::nan(""); }), "position"));
  EXPECT_TRUE(
      contains(defect([](auto& message) { message.pose.orientation.z = 7.0; }), "quaternion"));
  EXPECT_TRUE(contains(defect([](auto& message) { message.covariance[0] = -1.0; }), "covariance"));
  EXPECT_TRUE(contains(defect([](auto& message) { message.covariance[1] = 0.5; }), "covariance"));
  EXPECT_TRUE(
      contains(defect([](auto& message) { message.covariance[35] = std::nan(""); }), "covariance"));
  EXPECT_TRUE(
      contains(defect([](auto& message) { message.covariance[35] = 1e300; }), "covariance"));
}

TEST(MessageConversion, PosesSurviveTheWayThereAndBack) {
  for (const double theta : {-3.1, -1.0, 0.0, 0.4, 3.1}) {
    const Pose2 pose = to_pose2(to_pose_message(Pose2{1.0, -2.0, theta}));
    EXPECT_DOUBLE_EQ(pose.x, 1.0);
    EXPECT_DOUBLE_EQ(pose.y, -2.0);
    EXPECT_NEAR(pose.theta, theta, 1e-12);
  }
}

}  // namespace
}  // namespace matchbox_slam
