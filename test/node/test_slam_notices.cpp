// Of node/slam_node.hpp: what it says of other nodes and of odd scans, and when it sends its
// transform.

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <functional>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "node/node_process.hpp"
#include "ros/messages.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {
namespace {

/// What /diagnostics says of the mapping last.
class DiagnosticsWatch {
 public:
  [[nodiscard]] const diagnostic_msgs::DiagnosticStatus& status() const { return status_; }

 private:
  void on_diagnostics(const diagnostic_msgs::DiagnosticArray& message) {
    for (const diagnostic_msgs::DiagnosticStatus& status : message.status) {
      status_ = status;
    }
  }

  ros::NodeHandle node_;
  diagnostic_msgs::DiagnosticStatus status_;
  ros::Subscriber diagnostics_ =
      node_.subscribe("/diagnostics", 100, &DiagnosticsWatch::on_diagnostics, this);
};

TEST(SlamNotices, AnotherLocaliserIsNamedAndOurselvesAreNot) {
  Robot robot;
  const DiagnosticsWatch diagnostics;
  LogWatch log("tf that touches the map frame is ignored: ");
  ros::NodeHandle node;
  const ros::Publisher transforms = node.advertise<tf2_msgs::TFMessage>("/tf", 10);
  const TemporaryFolder folder;
  NodeProcess process("beside_another", folder, {"_transform_publish_period:=0.01"});
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(20));
  EXPECT_EQ(log.line(), "");
  ASSERT_TRUE(wait_until([&] {
    transforms.publish(make_transforms({make_transform(1000.0, "map", "odom", 3.0)}));
    return !log.line().empty();
  })) << "it says nothing";
  EXPECT_EQ(log.line(), "tf that touches the map frame is ignored: map -> odom, published by " +
                            ros::this_node::getName() +
                            "; if that is another localiser, set publish_tf to false or stop it");
  EXPECT_TRUE(wait_until([&] {
    return diagnostics.status().message == log.line() || !robot.drive(1);
  })) << "it says nothing";
  EXPECT_EQ(diagnostics.status().message, log.line());
  EXPECT_EQ(diagnostics.status().level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamNotices, AStopAtAJumpOfTimeSaysHowToGoOn) {
  Robot robot;
  LogWatch log("no scan is used any more");
  const TemporaryFolder folder;
  NodeProcess process("stopping", folder, {"_time_jump:=stop"});
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(20));
  robot.rest(-100.0);
  ASSERT_TRUE(wait_until([&] {
    robot.step();
    return !log.line().empty();
  })) << "it says nothing";
  EXPECT_TRUE(contains(log.line(), "rosservice call /stopping/save_map saves it")) << log.line();
  EXPECT_TRUE(contains(log.line(), "rosservice call /stopping/reset forgets it and begins anew"));
  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("/stopping/reset", reset));
  EXPECT_TRUE(robot.drive(5)) << "it does not go on";
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamNotices, ASecondOdometryIsToldInTheLogAndByDiagnostics) {
  Robot robot;
  LogWatch log("two nodes publish tf from the odometry frame 'odom': ");
  const DiagnosticsWatch diagnostics;
  const TemporaryFolder folder;
  NodeProcess process("of_two_odometries", folder);
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(20));
  EXPECT_EQ(log.line(), "");
  const std::string message =
      "{transforms: [{header: {frame_id: odom, stamp: {secs: 1000}}, child_frame_id: cart, "
      "transform: {rotation: {w: 1}}}]}";
  Process other({"rostopic", "pub", "-r", "20", "/tf", "tf2_msgs/TFMessage", message});
  const auto drives_until = [&](const std::function<bool()>& is_so) {
    return wait_until([&] { return is_so() || (robot.drive(1) && is_so()); });
  };
  ASSERT_TRUE(drives_until([&] { return !log.line().empty(); })) << "it says nothing";
  EXPECT_TRUE(contains(log.line(), ros::this_node::getName())) << log.line();
  EXPECT_TRUE(contains(log.line(), "/rostopic_")) << log.line();
  EXPECT_TRUE(contains(log.line(), "stop one of them")) << log.line();
  EXPECT_TRUE(drives_until([&] { return diagnostics.status().message == log.line(); }))
      << diagnostics.status().message;
  EXPECT_EQ(diagnostics.status().level, diagnostic_msgs::DiagnosticStatus::WARN);
  other.exit_code_after(SIGINT);
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

/// The transforms from the map that have come.
class MapLinks {
 public:
  [[nodiscard]] int count() const { return count_; }

 private:
  void on_transforms(const tf2_msgs::TFMessage& message) {
    count_ += find_map_link(message, "map").empty() ? 0 : 1;
  }

  ros::NodeHandle node_;
  int count_ = 0;
  ros::Subscriber transforms_ = node_.subscribe("/tf", 1000, &MapLinks::on_transforms, this);
};

TEST(SlamNotices, EachScanSendsTheTransform) {
  Robot robot;
  MapLinks links;
  const TemporaryFolder folder;
  NodeProcess process("at_once", folder, {"_transform_publish_period:=10"});
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(20));
  EXPECT_TRUE(wait_until([&] { return links.count() >= 20; })) << links.count();
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamNotices, TheTransformIsRepeatedWhileNoScanComes) {
  Robot robot;
  MapLinks links;
  const TemporaryFolder folder;
  NodeProcess process("repeating", folder);
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(1));
  const int before = links.count();
  EXPECT_TRUE(wait_until([&] { return links.count() >= before + 20; })) << links.count();
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamNotices, NamesWhatIsNoScan) {
  LogWatch log(", which is no scan; it is ignored");
  const TemporaryFolder folder;
  NodeProcess process("hears_words", folder, {"scan:=/words"});
  ASSERT_TRUE(log.hears_the_node());
  ros::NodeHandle node;
  const ros::Publisher words = node.advertise<std_msgs::String>("/words", 1, true);
  words.publish(std_msgs::String());
  ASSERT_TRUE(wait_until([&] { return !log.line().empty(); })) << "it says nothing";
  EXPECT_EQ(log.line(), ros::this_node::getName() +
                            " publishes std_msgs/String on /words, which is no scan; it is "
                            "ignored. Allowed: sensor_msgs/LaserScan, "
                            "sensor_msgs/MultiEchoLaserScan, sensor_msgs/PointCloud2");
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
}

TEST(SlamNotices, CutsBeamsThatReadTheLargestRangePlusNoise) {
  LogWatch log("plus noise");
  ros::NodeHandle node;
  const ros::Publisher scans = node.advertise<sensor_msgs::LaserScan>("/far_scan", 100);
  std::atomic<double> newest{0.0};
  using Pose = geometry_msgs::PoseWithCovarianceStamped;
  const boost::function<void(const Pose::ConstPtr&)> on_pose = [&](const Pose::ConstPtr& pose) {
    newest = pose->header.stamp.toSec();
  };
  const ros::Subscriber poses = node.subscribe<Pose>("/pose", 100, on_pose);
  const TemporaryFolder folder;
  NodeProcess process("far", folder, {"scan:=/far_scan", "_use_odometry:=false"});
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return scans.getNumSubscribers() > 0; }));
  double stamp = 1000.0;
  double told = 0.0;
  ASSERT_TRUE(wait_until([&] {
    sensor_msgs::LaserScan scan = make_scan(stamp += 0.05, "base");
    for (std::size_t k = 0; k < scan.ranges.size(); k += 2) {
      scan.ranges[k] = scan.range_max +
                       0.02F * std::sin(static_cast<float>(k) + 50.0F * static_cast<float>(stamp));
    }
    scans.publish(scan);
    told = told == 0.0 && !log.line().empty() ? stamp : told;
    return told > 0.0 && newest > told;
  })) << log.line();
  EXPECT_TRUE(contains(log.line(), "scan/max_range is set to 29.8")) << log.line();
  EXPECT_TRUE(contains(log.line(), "the map begins anew")) << log.line();
  ASSERT_TRUE(save("far").success);
  const MapImage map = read_map(folder / "map.yaml");
  EXPECT_LT(map.resolution * std::max(map.width, map.height), 12.0) << "an arc at 30 m is left";
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
}

TEST(SlamNotices, WhereNoScanCouldBeUsedSaveMapSaysWhy) {
  LogWatch log("(no_transform)");
  ros::NodeHandle node;
  const ros::Publisher scans = node.advertise<sensor_msgs::LaserScan>("/scan", 100);
  const TemporaryFolder folder;
  NodeProcess process("useless", folder);
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return scans.getNumSubscribers() > 0; }));
  double stamp = 1000.0;
  ASSERT_TRUE(wait_until([&] {
    scans.publish(make_scan(stamp += 0.05, "nowhere"));
    return !log.line().empty();
  })) << "it says nothing";
  const std_srvs::Trigger::Response saved = save("useless");
  EXPECT_FALSE(saved.success);
  EXPECT_TRUE(contains(saved.message, "no scan was mapped yet, nothing is saved: of "))
      << saved.message;
  EXPECT_TRUE(contains(saved.message, "; the last: ")) << saved.message;
  EXPECT_TRUE(contains(saved.message, "'nowhere'")) << saved.message;
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
}

}  // namespace
}  // namespace matchbox_slam
