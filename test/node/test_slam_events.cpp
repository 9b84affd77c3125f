// Of node/slam_node.hpp: what happens to the node between scans, and a loop: map_bag repeats it to
// the byte.

#include <dynamic_reconfigure/Reconfigure.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <std_srvs/Empty.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/Relocalise.h"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/bag_player.hpp"
#include "node/slam_listener.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"
#include "ros/scan_types.hpp"
#include "run/events_file.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

SimulatedRun simulate(const std::string& bag, const std::string& name, std::uint64_t seed,
                      const SimulationOptions& options, const SimulatedBagOptions& recording = {}) {
  const World world = make_world(name, seed);
  SimulatedRun run = simulate_run(world, world.route(), options, seed);
  SimulatedBagWriter(bag, recording).write(run, {name, seed, options.laser, run.faults});
  return run;
}

void set_parameters(const std::string& node, const TemporaryFolder& folder) {
  ros::param::set(node + "/base_frame", "base_footprint");
  ros::param::set(node + "/odom_frame", "odom_combined");
  ros::param::set(node + "/trajectory_file", folder / "node.tum");
  ros::param::set(node + "/map_file", folder / "map");
  ros::param::set(node + "/events_file", folder / "events.yaml");
}

/// The trajectory that map_bag makes of a bag.
std::string mapped(const std::string& bag, const TemporaryFolder& folder,
                   const std::string& options = "") {
  const Outcome outcome =
      run_command(MATCHBOX_MAP_BAG, bag + " --quiet --out " + (folder / "map_bag") + options);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  return read_file(folder / "map_bag/trajectory.tum");
}

/// The same with the events of the node, where set_parameters says.
std::string repeated(const std::string& bag, const TemporaryFolder& folder,
                     const std::string& options = "") {
  return mapped(bag, folder, options + " --events " + (folder / "events.yaml"));
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

void be_anywhere() {
  std_srvs::Empty service;
  ASSERT_TRUE(ros::service::call("/global_localization", service));
}

void tell_pose(const Pose2& map_from_base) {
  ros::NodeHandle node;
  ros::Publisher poses =
      node.advertise<geometry_msgs::PoseWithCovarianceStamped>("/initialpose", 10);
  ASSERT_TRUE(wait_until_so([&] { return poses.getNumSubscribers() > 0; }));
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
  be_anywhere();
  ASSERT_TRUE(player.drive(5));
  tell_pose({3.01, 2.0, 1.0});  // before it is found, which would move what the node told
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
  SimulationOptions options;
  options.time.duration = 20.0;
  simulate(bag, "rooms", 4, options);
  set_parameters("/repeated", folder);
  ros::AsyncSpinner spinner(2);
  spinner.start();
  Player player(bag);
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/repeated"));
    ASSERT_TRUE(wait_until_so([&] { return player.is_heard(); }));
    drive_with_events(player, folder / "map");
  }
  ASSERT_FALSE(HasFatalFailure());
  const std::string node = read_file(folder / "node.tum");
  ASSERT_GT(node.size(), 10000U);
  // The node has ended before the bag does.
  EXPECT_TRUE(node == repeated(bag, folder).substr(0, node.size()))
      << read_file(folder / "events.yaml");

  const MatcherLoader loader;
  std::set<std::size_t> kinds;
  for (const TimedEvent& event :
       read_events_file(folder / "events.yaml", LiveConfiguration({}, loader))) {
    kinds.insert(event.event.index());
  }
  EXPECT_GE(kinds.size(), std::variant_size_v<RunEvent> - 1) << "but for scans left out";
}

TEST(SlamEvents, MapBagLeavesOutTheScansThatTheNodeHadNoTimeFor) {
  const TemporaryFolder folder;
  const std::string bag = folder / "run.bag";
  SimulationOptions options;
  options.time.duration = 40.0;
  simulate(bag, "rooms", 4, options);
  set_parameters("/hurried", folder);
  ros::param::set("/hurried/max_lag", 0.01);
  ros::AsyncSpinner spinner(2);
  spinner.start();
  Player player(bag);
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/hurried"));
    ASSERT_TRUE(wait_until_so([&] { return player.is_heard(); }));
    ASSERT_TRUE(player.drive(10));
    player.play(200);  // faster than any matcher
    ASSERT_TRUE(player.drive(50));
  }
  const std::vector<TimedEvent> events =
      read_events_file(folder / "events.yaml", LiveConfiguration({}, MatcherLoader()));
  EXPECT_GT(std::count_if(events.begin(), events.end(),
                          [](const TimedEvent& event) {
                            return std::holds_alternative<LeaveOut>(event.event);
                          }),
            20);
  const std::string node = read_file(folder / "node.tum");
  ASSERT_GT(node.size(), 3000U);
  EXPECT_TRUE(node == repeated(bag, folder).substr(0, node.size()));
}

TEST(SlamEvents, APoseToldBeforeTheFirstScanOfAResumedMapIsTakenAsByMapBag) {
  const TemporaryFolder folder;
  const std::string bag = folder / "run.bag";
  SimulationOptions options;
  options.time.duration = 8.0;
  simulate(bag, "rooms", 4, options);
  ASSERT_EQ(run_command(MATCHBOX_MAP_BAG, bag + " --quiet --out " + (folder / "")).exit_code, 0);
  options.time.start_stamp += 3600.0;
  simulate(bag, "rooms", 4, options);  // another drive, from the same start
  set_parameters("/resumed", folder);
  ros::param::set("/resumed/resume", true);
  ros::AsyncSpinner spinner(2);
  spinner.start();
  Player player(bag);
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/resumed"));
    ASSERT_TRUE(wait_until_so([&] { return player.is_heard(); }));
    tell_pose({0.05, -0.05, 0.02});
    ASSERT_TRUE(player.drive(30));
  }
  const std::string by_map_bag = repeated(bag, folder, " --map " + (folder / "map.slam"));
  const std::string node = read_file(folder / "node.tum");
  ASSERT_GT(node.size(), 1000U);
  const std::size_t poses = by_map_bag.find('\n') + 1;  // behind a comment on the map
  EXPECT_TRUE(node == by_map_bag.substr(poses, node.size()));
  EXPECT_LT(read_tum(folder / "node.tum").poses().front().pose.translation().norm(), 0.02);
}

/// Lines of the log with these words, up to the one that says `end`.
int lines_until(const std::string& end, const std::string& words,
                const std::vector<std::string>& log, std::mutex& mutex) {
  int count = 0;
  EXPECT_TRUE(wait_until_so([&] {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto last = std::find(log.begin(), log.end(), end);
    count = static_cast<int>(std::count_if(
        log.begin(), last, [&](const std::string& line) { return contains(line, words); }));
    return last != log.end();
  }));
  return count;
}

TEST(SlamEvents, AMapThatIsNotSavedAtTheEndIsTold) {
  const TemporaryFolder folder;
  const std::string bag = folder / "run.bag";
  SimulationOptions options;
  options.time.duration = 4.0;
  simulate(bag, "rooms", 4, options);
  std::mutex mutex;
  std::vector<std::string> log;
  ros::NodeHandle node;
  const ros::Subscriber lines = node.subscribe<rosgraph_msgs::Log>(
      "/rosout", 1000, [&](const rosgraph_msgs::Log::ConstPtr& line) {
        const std::lock_guard<std::mutex> lock(mutex);
        log.push_back(line->msg);
      });
  ros::AsyncSpinner spinner(2);
  spinner.start();
  for (const bool saves : {false, true}) {
    const std::string name = saves ? "/saving" : "/forgetting";
    set_parameters(name, folder);
    Player player(bag);
    {
      const SlamNode slam(ros::NodeHandle(), ros::NodeHandle{name});
      ASSERT_TRUE(wait_until_so([&] { return player.is_heard() && lines.getNumPublishers() > 0; }));
      ASSERT_TRUE(player.drive(20));
      std_srvs::SetBool pause;  // else scans that are still on their way are used after saving
      pause.request.data = 1;
      ASSERT_TRUE(ros::service::call(name + "/pause", pause));
      std_srvs::Trigger save;
      ASSERT_TRUE(!saves || ros::service::call(name + "/save_map", save));
    }
    ROS_INFO_STREAM("ended " << name);
    EXPECT_EQ(
        lines_until("ended " + name, "rosservice call " + name + "/save_map saves it", log, mutex),
        saves ? 0 : 1);
  }
}

TEST(SlamEvents, MapBagTakesRollAndPitchFromAnImuAsTheNodeDoes) {
  const TemporaryFolder folder;
  const std::string bag = folder / "run.bag";
  SimulationOptions options;
  options.time.duration = 8.0;
  options.laser.rock = 0.1;
  options.laser.floor = true;
  options.laser.time_increment = 2e-5;
  SimulatedBagOptions recording;
  recording.imu = true;
  simulate(bag, "rooms", 4, options, recording);
  set_parameters("/rocking", folder);
  ros::param::set("/rocking/imu_topic", "imu");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  Player player(bag);
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/rocking"));
    ASSERT_TRUE(wait_until_so([&] { return player.is_heard(); }));
    ASSERT_TRUE(player.drive(150));
  }
  const std::string node = read_file(folder / "node.tum");
  ASSERT_GT(node.size(), 5000U);
  EXPECT_NE(node, mapped(bag, folder).substr(0, node.size()));
  EXPECT_TRUE(node == mapped(bag, folder, " --set imu_topic=imu").substr(0, node.size()));
}

/// What the node makes of a bag's first scans, from this topic.
std::string mapped_by_node(const std::string& bag, const std::string& topic,
                           const TemporaryFolder& folder) {
  const std::string name = "/reads" + topic;
  set_parameters(name, folder);
  ros::param::set(name + "/scan_topics", std::vector<std::string>{topic});
  Player player(bag);
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle{name});
    EXPECT_TRUE(wait_until_so([&] { return player.is_heard(); }));
    EXPECT_TRUE(player.drive(100));
  }
  return read_file(folder / "node.tum");
}

TEST(SlamEvents, MapBagReadsEchoesAndCloudsAsTheNodeDoes) {
  const TemporaryFolder folder;
  const std::string bag = folder / "run.bag";
  SimulationOptions options;
  options.time.duration = 8.0;
  simulate(bag, "rooms", 4, options);
  const std::string echoes = folder / "echoes.bag";
  convert_bag(bag, echoes, "/base_scan", "/echoes", to_multi_echo);
  const std::string clouds = folder / "clouds.bag";
  convert_bag(bag, clouds, "/base_scan", "/points", to_cloud);
  ros::AsyncSpinner spinner(2);
  spinner.start();
  const std::string by_echoes = mapped_by_node(echoes, "/echoes", folder);
  ASSERT_GT(by_echoes.size(), 3000U);
  EXPECT_TRUE(by_echoes == mapped(echoes, folder).substr(0, by_echoes.size()));
  EXPECT_TRUE(by_echoes == mapped(bag, folder).substr(0, by_echoes.size())) << "a laser scan";
  const std::string by_clouds = mapped_by_node(clouds, "/points", folder);
  ASSERT_GT(by_clouds.size(), 3000U);
  EXPECT_TRUE(by_clouds == mapped(clouds, folder).substr(0, by_clouds.size()));
}

/// A lap round a block by odometry alone, which is metres off when it comes home.
class SlamLoop : public testing::Test {
 protected:
  SlamLoop() {
    SimulationOptions options;
    options.laser.beams = 200;
    options.laser.scan_rate = 2.0;
    options.drive.speed = 1.0;
    run_ = simulate(bag_, "loop", 3, options);
    set_parameters("/looping", folder_);
    ros::param::set("/looping/matcher", "odometry_only");
    // Where odometry alone places them, neighbouring key scans hardly fit each other.
    ros::param::set("/looping/loops/decisive", 0.0);
    ros::param::set("/looping/loops/most_rival", 0.95);
    ros::param::set("/looping/map_update_interval", 0.2);
  }

  /// Publishes scans, each when the one before has its pose, until it is so or there are no more.
  void play_until(Player& player, const std::function<bool()>& is_so) {
    while (!is_so() && !player.is_at_end()) {
      player.play(1);
      ++played_;
      ASSERT_TRUE(listener_.wait_until(
          [&] { return std::min(listener_.poses.size(), listener_.matches.size()) + 1 >= played_; },
          10));
    }
  }

  /// Whether all that is published comes to tell of the newest pose, and of the newest key scan.
  bool all_follow() {
    return listener_.wait_until([this] { return all_are_new(); }, 5.0);
  }

  /// How far the path is from the truth, at most [m].
  [[nodiscard]] double error_of_path() const {
    std::map<ros::Time, Pose2> truth;
    for (std::size_t k = 0; k < run_.scans.size(); ++k) {
      truth[ros::Time(run_.scans[k].stamp)] =
          run_.world_from_base.front().inverse() * run_.world_from_base[k];
    }
    double most = 0.0;
    for (const geometry_msgs::PoseStamped& pose : listener_.path.poses) {
      const Pose2 error = truth.at(pose.header.stamp).inverse() * to_pose2(pose.pose);
      most = std::max(most, error.translation().norm());
    }
    return most;
  }

  /// Lines of a kind in the constraints.
  [[nodiscard]] std::size_t lines(const std::string& name) const {
    for (const visualization_msgs::Marker& marker : constraints_.markers) {
      if (marker.ns == name) {
        return marker.points.size() / 2;
      }
    }
    return 0;
  }

  const TemporaryFolder folder_;
  const std::string bag_ = folder_ / "loop.bag";
  SimulatedRun run_;
  SlamListener listener_;
  nav_msgs::OccupancyGrid map_;
  visualization_msgs::MarkerArray constraints_;

 private:
  [[nodiscard]] bool all_are_new() const {
    const geometry_msgs::PoseWithCovarianceStamped& newest = listener_.poses.back();
    const ros::Time stamp = newest.header.stamp;
    const auto key = std::find_if(listener_.matches.rbegin(), listener_.matches.rend(),
                                  [](const MatchInfo& match) { return match.inserted != 0; });
    const Pose2 odom_from_base = project_to_plane(
        listener_.transforms.lookup("odom_combined", "base_footprint", stamp).value());
    const Pose2 map_from_odom = to_pose2(newest.pose.pose) * odom_from_base.inverse();
    return difference(listener_.map_from_odom, map_from_odom).norm() < 1e-6 &&
           listener_.path.header.stamp == stamp && map_.header.stamp >= key->header.stamp &&
           !constraints_.markers.empty() &&
           constraints_.markers.front().header.stamp >= key->header.stamp;
  }

  void on_map(const nav_msgs::OccupancyGrid& map) { map_ = map; }
  void on_constraints(const visualization_msgs::MarkerArray& markers) { constraints_ = markers; }

  std::size_t played_ = 0;
  ros::NodeHandle node_;
  ros::Subscriber maps_ = node_.subscribe("map", 10, &SlamLoop::on_map, this);
  ros::Subscriber markers_ = node_.subscribe("constraints", 10, &SlamLoop::on_constraints, this);
};

TEST_F(SlamLoop, IsInAllThatIsSavedWhileItIsSearchedFor) {
  constexpr std::size_t kBefore = 234;  // scans; the next but one would close the first loop
  Player player(bag_);
  const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/looping"));
  ASSERT_TRUE(listener_.wait_until([&] { return player.is_heard(); }, 10.0));
  play_until(player, [&] { return listener_.matches.size() >= kBefore; });
  for (const MatchInfo& match : listener_.matches) {
    ASSERT_EQ(match.closed_loop, 0);
  }
  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call("/looping/save_map", save));
  const EngineState map = read_saved_map(folder_ / "map.slam");
  EXPECT_EQ(count_closed(map.loops.loops), 1U) << "else nothing was searched for";
  const Trajectory trajectory = read_tum(folder_ / "node.tum");
  const std::optional<Pose2> told = trajectory.at(map.motion.stamp.value(), 0.01);
  ASSERT_TRUE(told);
  EXPECT_LT(difference(map.motion.fixed_from_base, *told).norm(), 1e-6);

  // Diagnostics count what this run closes, not what a map brings.
  const auto tells = [&](const std::string& loops) {
    return listener_.wait_until([&] { return listener_.value_of("Loops closed") == loops; }, 10.0);
  };
  EXPECT_TRUE(tells("1"));
  LoadMap load;
  load.request.path = folder_ / "map.slam";
  ASSERT_TRUE(ros::service::call("/looping/load_map", load));
  ASSERT_TRUE(load.response.success) << load.response.message;
  EXPECT_TRUE(tells("0"));
}

TEST_F(SlamLoop, MovesAllThatTheNodePublishes) {
  Player player(bag_);
  const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/looping"));
  ASSERT_TRUE(listener_.wait_until([&] { return player.is_heard(); }, 10.0));
  const auto closed = [&] {
    return std::count_if(listener_.matches.begin(), listener_.matches.end(),
                         [](const MatchInfo& match) { return match.closed_loop != 0; });
  };
  play_until(player, [&] { return listener_.matches.size() >= 200; });
  EXPECT_EQ(closed(), 0);
  EXPECT_TRUE(all_follow());
  EXPECT_EQ(lines("loops"), 0U);
  EXPECT_GT(error_of_path(), 4.5);  // 5.5

  play_until(player, [&] { return closed() > 0; });
  ASSERT_EQ(closed(), 1);
  EXPECT_TRUE(all_follow());
  EXPECT_EQ(lines("loops"), 1U);
  EXPECT_LT(error_of_path(), 2.5);  // 2.1: odometry is off by that on the other side of the block

  play_until(player, [] { return false; });
  EXPECT_EQ(closed(), 2);
  EXPECT_TRUE(all_follow());
  EXPECT_EQ(lines("loops"), 2U);
  EXPECT_GE(lines("motion"), 250U);  // 260: the key scans, and what they were matched with

  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call("/looping/save_map", save));
  const Outcome mapped = run_command(
      MATCHBOX_MAP_BAG,
      bag_ +
          " --quiet --matcher odometry_only --set loops/decisive=0 --set loops/most_rival=0.95"
          " --out " +
          (folder_ / "map_bag"));
  ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
  EXPECT_TRUE(read_file(folder_ / "node.tum") == read_file(folder_ / "map_bag/trajectory.tum"));
  EXPECT_TRUE(read_file(folder_ / "map.pgm") == read_file(folder_ / "map_bag/map.pgm"));
  const MapImage image = read_map(folder_ / "map.yaml");
  ASSERT_EQ(static_cast<int>(map_.info.width), image.width);
  ASSERT_EQ(static_cast<int>(map_.info.height), image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
      if (map_.data[row + static_cast<std::size_t>(x)] > 65) {
        ASSERT_EQ(image.state({x, y}), CellState::kOccupied) << x << " " << y;
      }
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
