// Of tools/bag_mapper.hpp: what bags hold, and how they tell it.

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/view.h>

#include <filesystem>

#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "tools/map_bag_run.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

TEST_F(MapBag, TakesEachKindOfBag) {
  for (const auto compression : {rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    SmallBag recipe;
    recipe.compression = compression;
    ASSERT_EQ(run_small(recipe).exit_code, 0);
    EXPECT_EQ(poses(), 50U);
  }
}

TEST_F(MapBag, TakesSeveralBagsInAnyOrder) {
  SmallBag second;
  second.begin = 1005.0;
  write_small_bag(folder_ / "second.bag", second);
  ASSERT_EQ(run_small({}, "").exit_code, 0);
  const Outcome outcome = run(folder_ / "second.bag");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 100U);
}

TEST_F(MapBag, TakesAPeriod) {
  ASSERT_EQ(run_small({}, "--start 2.05 --duration 1").exit_code, 0);
  EXPECT_EQ(poses(), 10U);
  EXPECT_EQ(run("--quiet --start 2.05 --duration 1").output, "");
  std::filesystem::remove_all(out_);
  expect_one_line(run("--start 1000"), 1, "holds no scan on topic /scan in the period asked for");
}

TEST_F(MapBag, TakesFramesWithLeadingSlashes) {
  SmallBag recipe;
  recipe.odom_frame = "/odom_combined";
  recipe.base_frame = "/base_footprint";
  recipe.laser_frame = "/base_laser_link";
  for (const char* frames : {"", "--base-frame /base_footprint --odom-frame odom_combined"}) {
    ASSERT_EQ(run_small(recipe, frames).exit_code, 0);
    EXPECT_EQ(poses(), 50U);
  }
}

TEST_F(MapBag, IgnoresAMapThatTheBagHoldsAndSaysSoOnce) {
  SmallBag recipe;
  recipe.other_parent = "/map";
  const Outcome outcome = run_small(recipe);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string said = "tf in the bag that touches the map frame is ignored: map -> odom";
  const std::size_t first = outcome.output.find(said);
  EXPECT_NE(first, std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find(said, first + 1), std::string::npos) << outcome.output;
  EXPECT_EQ(poses(), 50U);
}

TEST_F(MapBag, WaitsForTransformsThatComeAfterTheirScan) {
  SmallBag recipe;
  recipe.transform_delay = 1.5;
  ASSERT_EQ(run_small(recipe).exit_code, 0);
  EXPECT_EQ(poses(), 50U);
}

TEST_F(MapBag, CountsScansThatTransformsDoNotReach) {
  SmallBag recipe;
  recipe.transform_delay = 3.0;
  const Outcome outcome = run_small(recipe, "--set transform_timeout=1");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(contains(outcome.output,
                       "none of 50 scans could be used; the first: scan of "
                       "1000.000 s skipped (no_transform): no transform from "
                       "'laser' to 'base_link'"))
      << outcome.output;
}

TEST_F(MapBag, FindsAndCorrectsAnOffsetOfTheClocks) {
  SmallBag recipe;
  recipe.scan_clock = -82.2;
  const Outcome plain = run_small(recipe);
  EXPECT_EQ(plain.exit_code, 1);
  EXPECT_TRUE(contains(plain.output,
                       "the clocks of scans and tf differ: scans are 82.2 s behind; to "
                       "correct that give --set scan_time_offset=auto"))
      << plain.output;
  for (const char* offset : {"auto", "82.2"}) {
    const Outcome corrected = run(std::string("--set scan_time_offset=") + offset);
    EXPECT_EQ(corrected.exit_code, 0) << corrected.output;
    EXPECT_EQ(poses(), 50U);
    EXPECT_NEAR(report("estimated_clock_offset_s"), 82.2, 1e-3);
    EXPECT_NEAR(report("scan_time_offset_s"), 82.2, 1e-3);
  }
}

TEST_F(MapBag, MapsWithSeveralLasers) {
  write_small_bag(bag_);
  SmallBag back;
  back.scan_topic = "/back_scan";
  back.with_transforms = false;
  const std::string second = folder_ / "back.bag";
  write_small_bag(second, back);
  const Outcome outcome = run(second + " --set 'scan_topics=[/scan, /back_scan]'");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(report("scans/used"), 100.0);
  EXPECT_EQ(poses(), 50U) << "two lasers at one moment give one pose";
  const std::string first = read_file(out_ + "/trajectory.tum");
  const Outcome by_flags = run(second + " --scan-topic /scan --scan-topic /back_scan");
  EXPECT_EQ(by_flags.exit_code, 0) << by_flags.output;
  EXPECT_EQ(report("scans/used"), 100.0);
  EXPECT_EQ(read_file(out_ + "/trajectory.tum"), first);
}

TEST_F(MapBag, MapsFromTheLaserAlone) {
  SmallBag recipe;
  recipe.with_transforms = false;
  expect_one_line(
      run_small(recipe), 2,
      "tf in the bag says nothing of the scan's frame 'laser', so there is no odometry; "
      "to map from the laser alone give --no-odom");
  const Outcome outcome = run("--no-odom");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 50U);
  EXPECT_EQ(read_tum(out_ + "/odometry.tum").size(), 0U);
}

/// A copy of a bag in which the odometry is no tf, but nav_msgs/Odometry on /odom.
void move_odometry_to_topic(const std::string& from, const std::string& to) {
  rosbag::Bag in(from, rosbag::bagmode::Read);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    const auto links = message.instantiate<tf2_msgs::TFMessage>();
    if (links == nullptr) {
      out.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
      continue;
    }
    for (const geometry_msgs::TransformStamped& link : links->transforms) {
      if (link.header.frame_id != "odom_combined") {
        out.write("/tf", message.getTime(), make_transforms({link}));
        continue;
      }
      nav_msgs::Odometry odometry;
      odometry.header = link.header;
      odometry.child_frame_id = link.child_frame_id;
      odometry.pose.pose.position.x = link.transform.translation.x;
      odometry.pose.pose.position.y = link.transform.translation.y;
      odometry.pose.pose.orientation = link.transform.rotation;
      out.write("/odom", message.getTime(), odometry);
    }
  }
}

TEST_F(MapBag, OdometryOnATopicGivesTheBytesThatItGivesOnTf) {
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world rooms --seed 4 --duration 10 --beams 260 --scan-rate 5 --bag " +
                            bag_ + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  ASSERT_EQ(run("").exit_code, 0);
  const std::string trajectory = read_file(out_ + "/trajectory.tum");
  const std::string odometry = read_file(out_ + "/odometry.tum");
  const std::string by_topic = folder_ / "topic.bag";
  move_odometry_to_topic(bag_, by_topic);
  for (const std::string named : {"", " --odom-topic odom"}) {
    const Outcome outcome = run_command(MATCHBOX_MAP_BAG, by_topic + " --out " + out_ + named);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(
        contains(outcome.output, "; odometry on topic /odom, of base_footprint in odom_combined\n"))
        << outcome.output;
    EXPECT_EQ(read_file(out_ + "/trajectory.tum"), trajectory);
    EXPECT_EQ(read_file(out_ + "/odometry.tum"), odometry);
  }
  EXPECT_EQ(report("invalid_odometry"), 0.0);
}

TEST_F(MapBag, TakesTheLaserWhereItIsSaidToBe) {
  SmallBag recipe;
  recipe.laser_frame = "lidar";
  write_small_bag(bag_, recipe);
  ASSERT_EQ(run("").exit_code, 0);
  const std::string trajectory = read_file(out_ + "/trajectory.tum");
  // The same without the laser's place in tf.
  recipe.with_transforms = false;
  write_small_bag(bag_, recipe);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    for (int k = -2; k < 105; ++k) {
      const double stamp = 1000.0 + 0.05 * k;
      bag.write("/tf", ros::Time(stamp), make_link(stamp, "odom", "base_link", 0.001 * k));
    }
  }
  std::filesystem::remove_all(out_);
  expect_one_line(run(""), 2, "or say where the laser is on the robot with --laser-pose X,Y,YAW");
  expect_one_line(run("--laser-pose 0.2,zero,0"), 2, "allowed: [x, y, yaw] in m and rad");
  const Outcome outcome = run("--laser-pose 0.2,0,0");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(read_file(out_ + "/trajectory.tum"), trajectory);
  EXPECT_EQ(run("--laser-pose -0.2,0,0").exit_code, 0);
}

TEST_F(MapBag, SaysOnceThatTfHasTheLaserElsewhereThanItIsSaidToBe) {
  Outcome outcome = run_small({}, "--laser-pose 0.25,0,0");
  EXPECT_EQ(outcome.exit_code, 0);
  const std::string told =
      "tf has laser at 0.200,0.000,0.000 on base_link; --laser-pose "
      "0.250,0.000,0.000 is used instead\n";
  const std::size_t place = outcome.output.find(told);
  ASSERT_NE(place, std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find(told, place + 1), std::string::npos);
  outcome = run("--laser-pose 0.2,0,0");
  EXPECT_FALSE(contains(outcome.output, "instead")) << outcome.output;
}

TEST_F(MapBag, FixedLinksOnTfAreNoOdometry) {
  const Outcome simulated =
      run_command(MATCHBOX_SIMULATE, "--world rooms --duration 3 --beams 60 --no-odometry --bag " +
                                         bag_ + " --truth " + (folder_ / "truth.tum"));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  expect_one_line(run(""), 2,
                  "tf holds no link that moves, so there is no odometry; to map from the laser "
                  "alone give --no-odom, or name --odom-frame and --base-frame");
  const Outcome alone = run("--no-odom");
  EXPECT_EQ(alone.exit_code, 0) << alone.output;
  EXPECT_EQ(poses(), 61U);
  EXPECT_EQ(read_tum(out_ + "/odometry.tum").size(), 0U);
  const Outcome named = run("--odom-frame base_footprint --base-frame base_link");
  EXPECT_EQ(named.exit_code, 0) << named.output;
  EXPECT_GT(poses(), 50U);
}

/// What old recordings have besides: a map of their own, odometry that names no child, tf twice.
void add_old_habits(const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Append);
  for (int k = 0; k < 20; ++k) {
    const double stamp = 1327500000.0 + 0.05 * k;
    bag.write("/tf", ros::Time(stamp), make_link(stamp, "/map", "/odom_combined", 1.0));
    bag.write("/tf", ros::Time(stamp), make_link(1327500000.0, "/base_footprint", "/tilt", 1.0));
    nav_msgs::Odometry odometry;
    odometry.header.stamp = ros::Time(stamp);
    odometry.header.frame_id = "/odom_combined";
    bag.write("/base_odometry/odom", ros::Time(stamp), odometry);
  }
}

TEST_F(MapBag, TakesABagWithEveryQuirkOfMitStata) {
  const std::string truth_file = folder_ / "truth.tum";
  const Outcome simulated =
      run_command(MATCHBOX_SIMULATE,
                  "--world rooms --duration 10 --beams 360 --clock-offset 82.2 --leading-slashes "
                  "--compression bz2 --bag " +
                      bag_ + " --truth " + truth_file);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  add_old_habits(bag_);
  const Outcome outcome = run("--set scan_time_offset=auto");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "map -> odom_combined")) << outcome.output;
  EXPECT_NEAR(report("scan_time_offset_s"), 82.2, 0.05);
  // By the clock of the laser, as MIT's is.
  std::vector<StampedPose2> truth;
  const Trajectory recorded = read_tum(truth_file);
  for (StampedPose2 pose : recorded.poses()) {
    pose.stamp += report("scan_time_offset_s");
    truth.push_back(pose);
  }
  const Trajectory estimate = read_tum(out_ + "/trajectory.tum");
  EXPECT_GE(estimate.size() + 2, truth.size());
  EXPECT_LT(absolute_trajectory_error(estimate, Trajectory(truth)).translation.rmse, 0.02);
}

}  // namespace
}  // namespace matchbox_slam
