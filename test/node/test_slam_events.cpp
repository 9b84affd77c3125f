// What happens to the node between scans: map_bag repeats it to the byte.

#include <dynamic_reconfigure/Reconfigure.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/Relocalise.h"
#include "matchbox_slam/io/file.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"
#include "run/events_file.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

/// Looks again and again until it is so, or until it should long have been.
bool wait_until(const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!is_so() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return is_so();
}

/// Plays a bag to the node, as far as it is told to.
class Player {
 public:
  explicit Player(const std::string& bag)
      : bag_(bag, rosbag::bagmode::Read), view_(bag_), next_(view_.begin()) {}

  [[nodiscard]] bool is_heard() const {
    return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0 &&
           poses_.getNumPublishers() > 0;
  }

  /// Publishes so many scans, with all that was recorded before the last of them.
  void play(int scans) {
    for (; next_ != view_.end() && scans > 0; ++next_) {
      if (const auto scan = next_->instantiate<sensor_msgs::LaserScan>()) {
        scans_.publish(scan);
        --scans;
      } else if (const auto transforms = next_->instantiate<tf2_msgs::TFMessage>()) {
        transforms_.publish(transforms);
      }
    }
  }

  /// Publishes until so many more poses have come back.
  bool drive(int poses) {
    const int wanted = heard_ + poses;
    return wait_until([&] {
      if (heard_ < wanted) {
        play(1);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      return heard_ >= wanted;
    });
  }

  [[nodiscard]] int heard() const { return heard_; }

 private:
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& /*message*/) { ++heard_; }

  ros::NodeHandle node_;
  ros::Publisher scans_ = node_.advertise<sensor_msgs::LaserScan>("/scan", 1000);
  ros::Publisher transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  ros::Subscriber poses_ = node_.subscribe("/pose", 1000, &Player::on_pose, this);
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator next_;
  std::atomic<int> heard_{0};
};

void simulate(const std::string& bag) {
  SimulationOptions options;
  options.time.duration = 20.0;
  const World world = make_world("rooms", 4);
  const SimulatedRun run = simulate_run(world, world.route(), options, 4);
  SimulatedBagWriter(bag, {}).write(run, {"rooms", 4, options.laser, run.faults});
}

void pause(bool paused) {
  std_srvs::SetBool service;
  service.request.data = static_cast<std::uint8_t>(paused);
  ASSERT_TRUE(ros::service::call("/repeated/pause", service));
}

void choose(const std::string& matcher) {
  dynamic_reconfigure::Reconfigure service;
  service.request.config.strs.resize(1);
  service.request.config.strs[0].name = "matcher";
  service.request.config.strs[0].value = matcher;
  ASSERT_TRUE(ros::service::call("/repeated/set_parameters", service));
}

void reset() {
  std_srvs::Trigger service;
  ASSERT_TRUE(ros::service::call("/repeated/reset", service));
}

/// Saves the map, and goes on with it as if it were an old one.
void save_and_load(const std::string& map) {
  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call("/repeated/save_map", save));
  ASSERT_TRUE(save.response.success) << save.response.message;
  LoadMap load;
  load.request.path = map + ".slam";
  ASSERT_TRUE(ros::service::call("/repeated/load_map", load));
  ASSERT_TRUE(load.response.success) << load.response.message;
}

void relocalise() {
  Relocalise service;
  service.request.set_pose = 1;
  ASSERT_TRUE(ros::service::call("/repeated/relocalise", service));
  ASSERT_TRUE(service.response.pose_set) << service.response.message;
}

void tell_pose(const Pose2& map_from_base) {
  ros::NodeHandle node;
  ros::Publisher poses =
      node.advertise<geometry_msgs::PoseWithCovarianceStamped>("/initialpose", 10);
  ASSERT_TRUE(wait_until([&] { return poses.getNumSubscribers() > 0; }));
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = "map";
  message.pose.pose = to_pose_message(map_from_base);
  message.pose.covariance[0] = message.pose.covariance[7] = message.pose.covariance[35] = 0.01;
  poses.publish(message);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
}

/// All that may happen, at some moments of a drive.
void drive_with_events(Player& player, const std::string& map) {
  ASSERT_TRUE(player.drive(10));
  reset();
  tell_pose({3.0, 2.0, 1.0});  // where the new map begins
  ASSERT_TRUE(player.drive(10));
  save_and_load(map);
  ASSERT_TRUE(player.drive(5));
  tell_pose({3.01, 2.0, 1.0});
  ASSERT_TRUE(player.drive(60));
  pause(true);
  const int before = player.heard();
  player.play(10);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_LT(player.heard(), before + 2) << "scans are used while it is paused";
  pause(false);
  choose("hough");
  ASSERT_TRUE(player.drive(60));
  relocalise();
  choose("olson");
  ASSERT_TRUE(player.drive(40));
  player.play(40);  // and an end with scans that nobody waits for
}

TEST(SlamEvents, MapBagRepeatsThemToTheByte) {
  const TemporaryFolder folder;
  const std::string bag = folder / "run.bag";
  simulate(bag);
  ros::param::set("/repeated/base_frame", "base_footprint");
  ros::param::set("/repeated/odom_frame", "odom_combined");
  ros::param::set("/repeated/trajectory_file", folder / "node.tum");
  ros::param::set("/repeated/events_file", folder / "events.yaml");
  ros::param::set("/repeated/map_file", folder / "map");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  Player player(bag);
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/repeated"));
    ASSERT_TRUE(wait_until([&] { return player.is_heard(); }));
    drive_with_events(player, folder / "map");
  }
  ASSERT_FALSE(HasFatalFailure());
  const Outcome mapped =
      run_command(MATCHBOX_MAP_BAG, bag + " --quiet --out " + (folder / "map_bag") + " --events " +
                                        (folder / "events.yaml"));
  ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
  const std::string node = read_file(folder / "node.tum");
  const std::string repeated = read_file(folder / "map_bag/trajectory.tum");
  ASSERT_GT(node.size(), 10000U);
  // The node has ended before the bag does.
  EXPECT_TRUE(node == repeated.substr(0, node.size())) << read_file(folder / "events.yaml");

  const MatcherLoader loader;
  std::set<std::size_t> kinds;
  for (const TimedEvent& event :
       read_events_file(folder / "events.yaml", LiveConfiguration({}, loader))) {
    kinds.insert(event.event.index());
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<RunEvent>) << "not every kind";
}

}  // namespace
}  // namespace matchbox_slam

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "test_slam_events");
  const ros::NodeHandle keeps_ros_alive;
  return RUN_ALL_TESTS();
}
