#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include "bag/bag_survey.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/random.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"

namespace matchbox_slam {
namespace {

class SurveyBag : public testing::Test {
 protected:
  BagSurvey survey(const SmallBag& recipe) {
    write_small_bag(path_, recipe);
    return survey_bag(BagReader({path_}), {recipe.scan_topic}, {}, "map");
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "small.bag";
};

TEST_F(SurveyBag, FindsTheFrames) {
  const BagSurvey found = survey({});
  EXPECT_EQ(found.scan_frame, "laser");
  const BagFrames frames = choose_frames(found, {}, {}, true);
  EXPECT_EQ(frames.base, "base_link");
  EXPECT_EQ(frames.odom, "odom");
}

TEST_F(SurveyBag, FindsFramesWithLeadingSlashesAndLeavesOutTheMap) {
  SmallBag recipe;
  recipe.odom_frame = "/odom_combined";
  recipe.base_frame = "/base_footprint";
  recipe.laser_frame = "/base_laser_link";
  recipe.other_parent = "/map";
  const BagFrames frames = choose_frames(survey(recipe), {}, {}, true);
  EXPECT_EQ(frames.base, "base_footprint");
  EXPECT_EQ(frames.odom, "odom_combined");
}

TEST_F(SurveyBag, CompletesWhatWasAskedFor) {
  const BagSurvey found = survey({});
  EXPECT_EQ(choose_frames(found, "laser", {}, true).odom, "odom");
  EXPECT_EQ(choose_frames(found, {}, "odom", true).base, "base_link");
  EXPECT_EQ(choose_frames(found, {}, "base_link", true).base, "laser");
  EXPECT_TRUE(contains(
      error_text<ConfigurationError>([&] { (void)choose_frames(found, {}, "world", true); }),
      "above it are: base_link, odom"));
}

/// Of the second of two lasers, 20 of whose scans lie behind 60 of the first one's.
TEST_F(SurveyBag, FindsNoReturnsByEachLasersOwnScans) {
  write_small_bag(path_);
  rosbag::Bag bag(path_, rosbag::bagmode::Append);
  Random random(1);
  for (int i = 0; i < 40; ++i) {
    sensor_msgs::LaserScan scan = make_scan(1000.01 + 0.1 * i);
    for (std::size_t k = 0; k < scan.ranges.size(); k += 2) {
      scan.ranges[k] = scan.range_max + 0.02F * static_cast<float>(random.gaussian());
    }
    bag.write("/far_scan", ros::Time(1060.0 + 0.1 * i), scan);
  }
  bag.close();
  const BagReader reader({path_});
  EXPECT_FALSE(find_no_returns(reader, {"/scan"}, {}, {}));
  const std::optional<double> alone = find_no_returns(reader, {"/far_scan"}, {}, {});
  ASSERT_TRUE(alone);
  EXPECT_NEAR(*alone, 29.9, 0.03);
  EXPECT_EQ(find_no_returns(reader, {"/scan", "/far_scan"}, {}, {}), alone);
  EXPECT_FALSE(find_no_returns(reader, {"/far_scan"}, [] { return true; }, {}));
}

TEST_F(SurveyBag, RefusesFramesThatAreSwapped) {
  EXPECT_EQ(error_text<ConfigurationError>(
                [&] { (void)choose_frames(survey({}), "odom", "base_link", true); }),
            "odometry frame 'base_link' lies below base frame 'odom' in tf; are the two swapped?");
}

TEST_F(SurveyBag, WithoutOdometryTheSameBaseOrTheLaser) {
  EXPECT_EQ(choose_frames(survey({}), {}, {}, false).base, "base_link");
  SmallBag bare;
  bare.with_transforms = false;
  const BagSurvey found = survey(bare);
  const BagFrames frames = choose_frames(found, {}, {}, false);
  EXPECT_EQ(frames.base, "laser");
  EXPECT_FALSE(frames.odom);
  EXPECT_TRUE(
      contains(error_text<ConfigurationError>([&] { (void)choose_frames(found, {}, {}, true); }),
               "--no-odom"));
}

TEST_F(SurveyBag, DoesNotChooseBetweenParents) {
  BagSurvey found;
  found.scan_frame = "laser";
  found.parents = {{"laser", {"base", "gimbal"}}, {"base", {"odom"}}};
  EXPECT_EQ(
      error_text<ConfigurationError>([&] { (void)choose_frames(found, {}, {}, true); }),
      "frame 'laser' has several parents in tf: base, gimbal; say which with --odom-frame and "
      "--base-frame");
  found.parents = {{"laser", {"base"}}, {"base", {"laser"}}};
  EXPECT_TRUE(contains(
      error_text<ConfigurationError>([&] { (void)choose_frames(found, {}, {}, true); }), "circle"));
}

TEST_F(SurveyBag, StaticLinksAreNoOdometry) {
  BagSurvey found;
  found.scan_frame = "laser";
  found.parents = {{"laser", {"base"}}};
  EXPECT_TRUE(
      contains(error_text<ConfigurationError>([&] { (void)choose_frames(found, {}, {}, true); }),
               "tf holds no link that moves, so there is no odometry"));
  EXPECT_EQ(choose_frames(found, {}, {}, false).base, "base");
  EXPECT_EQ(choose_frames(found, "laser", "base", true).odom, "base");
}

TEST_F(SurveyBag, OnlyALinkThatChangesMoves) {
  const BagSurvey found = survey({});
  EXPECT_EQ(found.on_tf, (std::set<std::string>{"base_link", "laser"}));
  EXPECT_EQ(found.moving, std::set<std::string>{"base_link"});
}

TEST_F(SurveyBag, OdometryIsFoundByItsMotionOrItsName) {
  BagSurvey found;
  found.scan_frame = "laser";
  found.parents = {{"laser", {"base"}}, {"base", {"robot/odom"}}, {"robot/odom", {"world"}}};
  found.on_tf = {"laser", "base", "robot/odom"};
  EXPECT_EQ(choose_frames(found, {}, {}, true).odom, "robot/odom") << "a robot at rest";
  EXPECT_EQ(choose_frames(found, {}, {}, true).base, "base");
  found.parents = {{"laser", {"base"}}, {"base", {"start"}}, {"start", {"world"}}};
  found.on_tf = {"laser", "base", "start"};
  EXPECT_TRUE(
      contains(error_text<ConfigurationError>([&] { (void)choose_frames(found, {}, {}, true); }),
               "tf holds no link that moves"));
  found.moving = {"base"};
  EXPECT_EQ(choose_frames(found, {}, {}, true).odom, "start");
}

TEST_F(SurveyBag, EndsWhenInterrupted) {
  write_small_bag(path_);
  const BagSurvey found = survey_bag(BagReader({path_}), {"/scan"}, {}, "map", [] { return true; });
  EXPECT_EQ(found.scan_frame, "");
}

TEST_F(SurveyBag, MeasuresTheOffsetOfTheClocks) {
  SmallBag recipe;
  recipe.scan_clock = -82.2;
  EXPECT_NEAR(*survey(recipe).scan_time_offset, 82.2, 1e-6);
  recipe.scan_clock = 0.0;
  recipe.transform_delay = 0.02;
  EXPECT_NEAR(*survey(recipe).scan_time_offset, -0.02, 1e-6);
}

using Topics = std::vector<std::string>;

TEST_F(SurveyBag, PrefersLaserScansToEchoesAndTheseToClouds) {
  write_small_bag(path_);
  const std::string echoes = folder_ / "echoes.bag";
  convert_bag(path_, echoes, "/scan", "/echoes", to_multi_echo);
  const std::string clouds = folder_ / "clouds.bag";
  convert_bag(path_, clouds, "/scan", "/points", to_cloud);
  EXPECT_EQ(choose_scan_topics(BagReader({clouds}), {}), Topics{"/points"});
  EXPECT_EQ(choose_scan_topics(BagReader({clouds, echoes}), {}), Topics{"/echoes"});
  EXPECT_EQ(choose_scan_topics(BagReader({clouds, echoes, path_}), {}), Topics{"/scan"});
  EXPECT_EQ(choose_scan_topics(BagReader({clouds, echoes, path_}), {"/points"}), Topics{"/points"});
  EXPECT_TRUE(contains(error_text<ConfigurationError>([&] {
                         (void)choose_scan_topics(BagReader({clouds, path_}), {"/laser"});
                       }),
                       "topics with laser scans: /scan, /points"));
}

TEST_F(SurveyBag, ChoosesTheOnlyScanTopic) {
  write_small_bag(path_);
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    bag.write("/chatter", ros::Time(1000.0), std_msgs::String());
  }
  EXPECT_EQ(choose_scan_topics(BagReader({path_}), {}), Topics{"/scan"});
  EXPECT_EQ(choose_scan_topics(BagReader({path_}), {"scan"}), Topics{"/scan"});
  EXPECT_EQ(error_text<ConfigurationError>(
                [&] { (void)choose_scan_topics(BagReader({path_}), {"/chatter"}); }),
            "topic '/chatter' of the bag holds std_msgs/String, not sensor_msgs/LaserScan, "
            "sensor_msgs/MultiEchoLaserScan, sensor_msgs/PointCloud2; topics with laser scans: "
            "/scan");
  EXPECT_EQ(error_text<ConfigurationError>(
                [&] { (void)choose_scan_topics(BagReader({path_}), {"/laser"}); }),
            "the bag has no topic '/laser'; topics with laser scans: /scan");
}

TEST_F(SurveyBag, TellsWhatThereIsWhereNoTopicHasScans) {
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    bag.write("/chatter", ros::Time(1000.0), std_msgs::String());
    bag.write("/odom", ros::Time(1000.0), nav_msgs::Odometry());
  }
  EXPECT_EQ(
      error_text<ConfigurationError>([&] { (void)choose_scan_topics(BagReader({path_}), {}); }),
      "the bag has no topic of type sensor_msgs/LaserScan, sensor_msgs/MultiEchoLaserScan, "
      "sensor_msgs/PointCloud2; it has: /chatter (std_msgs/String), /odom (nav_msgs/Odometry); "
      "record the laser's topic, too");
}

TEST_F(SurveyBag, DoesNotChooseBetweenScanTopics) {
  write_small_bag(path_);
  SmallBag back;
  back.scan_topic = "/back_scan";
  back.with_transforms = false;
  write_small_bag(folder_ / "back.bag", back);
  EXPECT_EQ(error_text<ConfigurationError>([&] {
              (void)choose_scan_topics(BagReader({path_, folder_ / "back.bag"}), {});
            }),
            "the bag has several topics with laser scans: /back_scan, /scan; choose one with "
            "--scan-topic, or several by giving it for each");
  EXPECT_EQ(choose_scan_topics(BagReader({path_, folder_ / "back.bag"}), {"scan", "/back_scan"}),
            (Topics{"/scan", "/back_scan"}));
  EXPECT_EQ(error_text<ConfigurationError>([&] {
              (void)choose_scan_topics(BagReader({path_}), {"scan", "/scan"});
            }),
            "topic '/scan' is named twice");
}

}  // namespace
}  // namespace matchbox_slam
