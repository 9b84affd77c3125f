// Of node/slam_node.hpp: takes another robot's map in while it drives.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/MergeMap.h"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/slam_listener.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

/// A node on the first part of a way through rooms, and the map of another robot that drove on from
/// the middle of that, with noise of its own.
class Merging : public testing::Test {
 protected:
  void SetUp() override {
    other_ = drive(5, 1327600000.0, 70.0);
    const Outcome mapped = map("other.bag", other_, "--start 20", "other");
    ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
    run_ = drive(4, 1327500000.0, 50.0);
    SimulatedBagWriter(folder_ / "run.bag", {}).write(run_, {"rooms", kWorld, laser_, {}});
    bag_.open(folder_ / "run.bag", rosbag::bagmode::Read);
    ros::param::del("/merging");
    ros::param::set("/merging/base_frame", "base_footprint");
    ros::param::set("/merging/odom_frame", "odom_combined");
    ros::param::set("/merging/map_file", folder_ / "saved");
  }

  SimulatedRun drive(std::uint64_t noise, double start, double duration) {
    SimulationOptions options;
    options.time.duration = duration;
    options.time.start_stamp = start;
    options.laser.beams = 360;
    options.laser.scan_rate = 10.0;
    laser_ = options.laser;
    const World world = make_world("rooms", kWorld);
    return simulate_run(world, world.route(), options, noise);
  }

  Outcome map(const std::string& bag, const SimulatedRun& run, const std::string& part,
              const std::string& out) {
    SimulatedBagWriter(folder_ / bag, {}).write(run, {"rooms", kWorld, laser_, {}});
    return run_command(MATCHBOX_MAP_BAG,
                       (folder_ / bag) + " " + part + " --quiet --out " + (folder_ / out));
  }

  void start() {
    slam_ = std::make_unique<SlamNode>(ros::NodeHandle(), ros::NodeHandle("/merging"));
    ASSERT_TRUE(listener_.wait_until(
        [&] { return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0; },
        30.0));
  }

  /// Plays the drive from where it was left to a scan.
  void play(std::size_t to) {
    rosbag::View view(bag_);
    std::size_t message_number = 0;
    for (const rosbag::MessageInstance& message : view) {
      if (message_number++ < played_) {
        continue;
      }
      ++played_;
      if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
        transforms_.publish(*transforms);
      } else if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) {
        scans_.publish(*scan);
        // The newest ones wait for their transforms, which come after them.
        ASSERT_TRUE(
            listener_.wait_until([&] { return listener_.matches.size() + 6 >= published_; }, 20.0));
        if (++published_ >= to) {
          return;
        }
      }
    }
  }

  MergeMap::Response merge(const std::string& path) {
    ros::AsyncSpinner spinner(1);  // its answer comes from this process
    spinner.start();
    MergeMap service;
    service.request.path = path;
    EXPECT_TRUE(ros::service::call("/merging/merge_map", service));
    return service.response;
  }

  EngineState saved() {
    std_srvs::Trigger service;
    {
      ros::AsyncSpinner spinner(1);
      spinner.start();
      EXPECT_TRUE(ros::service::call("/merging/save_map", service));
    }
    EXPECT_TRUE(service.response.success) << service.response.message;
    return read_saved_map(folder_ / "saved.slam");
  }

  void expect_refused(const std::string& path, const std::string& words) {
    const MergeMap::Response answer = merge(path);
    EXPECT_FALSE(answer.success);
    EXPECT_TRUE(contains(answer.message, words)) << answer.message;
  }

  /// Largest distance [m] from the truth of a drive's key scans, which it counts.
  double largest_error(const EngineState& map, const SimulatedRun& run, std::size_t& count) const {
    const Pose2 map_from_world = run_.world_from_base.front().inverse();
    double largest = 0.0;
    count = 0;
    for (const PlacedScan& key : map.key_scans.all()) {
      for (std::size_t i = 0; i < run.scans.size(); ++i) {
        if (std::abs(run.scans[i].stamp - key.scan->stamp()) < 1e-3) {
          const Pose2 truth = map_from_world * run.world_from_base[i];
          largest =
              std::max(largest, (truth.translation() - key.map_from_base.translation()).norm());
          ++count;
        }
      }
    }
    return largest;
  }

  void on_log(const rosgraph_msgs::Log& log) { log_.push_back(log.msg); }
  [[nodiscard]] bool has_told(const std::string& words) const {
    return std::any_of(log_.begin(), log_.end(),
                       [&](const std::string& line) { return contains(line, words); });
  }

  static constexpr std::uint64_t kWorld = 4;
  TemporaryFolder folder_;
  LaserOptions laser_;
  SimulatedRun run_;
  SimulatedRun other_;
  rosbag::Bag bag_;
  ros::NodeHandle node_;
  ros::Publisher scans_ = node_.advertise<sensor_msgs::LaserScan>("/scan", 1000);
  ros::Publisher transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  SlamListener listener_;
  std::vector<std::string> log_;
  ros::Subscriber log_subscriber_ = node_.subscribe("/rosout", 1000, &Merging::on_log, this);
  std::size_t played_ = 0;     ///< messages
  std::size_t published_ = 0;  ///< scans
  std::unique_ptr<SlamNode> slam_;
};

TEST_F(Merging, TakesInTheMapOfAnotherRobotWhereTheyMeet) {
  const std::string other = folder_ / "other/map.slam";
  start();
  play(100);
  const MergeMap::Response answer = merge(other);
  ASSERT_TRUE(answer.success) << answer.message;
  play(350);
  // The search may take as long as it does; it is taken in with the next key scan.
  for (std::size_t next = 360; next <= 500 && !has_told("meets this map"); next += 10) {
    static_cast<void>(listener_.wait_until([&] { return has_told("meets this map"); }, 3.0));
    play(next);
  }
  ASSERT_TRUE(listener_.wait_until([&] { return has_told("meets this map"); }, 10.0));
  const std::size_t taken_at = published_;
  play(500);
  ASSERT_TRUE(
      listener_.wait_until([&] { return listener_.matches.size() + 6 >= published_; }, 20.0));
  EXPECT_EQ(listener_.matches.back().state, "tracking");
  const EngineState map = saved();
  std::size_t own = 0;
  std::size_t others = 0;
  const double own_error = largest_error(map, run_, own);
  const double others_error = largest_error(map, other_, others);
  const std::size_t given = read_saved_map(other).key_scans.size();
  RecordProperty("taken_in_at_scan", std::to_string(taken_at));
  RecordProperty("own_error", std::to_string(own_error));
  RecordProperty("others_error", std::to_string(others_error));
  std::cout << "taken in at scan " << taken_at << ", own error " << own_error << " m of " << own
            << ", other's " << others_error << " m of " << others << std::endl;
  EXPECT_EQ(others, given);
  EXPECT_EQ(own + others, map.key_scans.size());
  EXPECT_LE(own_error, 0.015);
  EXPECT_LE(others_error, 0.015);
  for (const auto& value : listener_.status.values) {
    EXPECT_TRUE(value.key.find("Scans skipped") != 0 || value.value == "0") << value.key;
  }
  EXPECT_TRUE(listener_.errors.empty()) << listener_.errors.front();
  // It is part of the map now.
  expect_refused(other, "are in this map already");
}

TEST_F(Merging, RefusesWhatCannotComeInAndKeepsItsMap) {
  const std::string other = folder_ / "other/map.slam";
  start();
  play(60);
  expect_refused(folder_ / "none.slam", "none.slam");
  expect_refused("none.slam", "/none.slam");  // where it was looked for
  expect_refused(folder_ / "other", "is a folder; give the map in it");
  expect_refused(folder_ / "run.bag", "map_bag");
  expect_refused(folder_ / "other/map.yaml", "give the .slam");
  const std::string whole = read_file(other);
  const std::string cut = folder_ / "cut.slam";
  replace_file(cut, whole.substr(0, whole.size() / 2));
  expect_refused(cut, cut);
  EXPECT_TRUE(merge(other).success);
  expect_refused(other, "is searched already");
  const EngineState map = saved();
  expect_refused(folder_ / "saved.slam", "are in this map already");
  std::size_t own = 0;
  largest_error(map, run_, own);
  EXPECT_EQ(own, map.key_scans.size());
}

}  // namespace
}  // namespace matchbox_slam
