// Of slam.launch: the node is killed in the middle of a drive. roslaunch starts it again, and it
// goes on with the map that it saved last.

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <xmlrpcpp/XmlRpc.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "ros/message_conversion.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

/// Plays a bag to the node whether that listens or not, and hears what it says.
class Drive {
 public:
  explicit Drive(const std::string& bag)
      : bag_(bag, rosbag::bagmode::Read), view_(bag_), next_(view_.begin()) {}

  [[nodiscard]] bool is_heard() const {
    return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0 &&
           poses_.getNumPublishers() > 0;
  }

  [[nodiscard]] bool is_at_end() { return next_ == view_.end(); }

  /// Publishes one scan and what was recorded before it, as long as that took the robot.
  void go_on() {
    for (bool is_scan = false; next_ != view_.end() && !is_scan; ++next_) {
      if (const auto scan = next_->instantiate<sensor_msgs::LaserScan>()) {
        scans_.publish(scan);
        is_scan = true;
      } else if (const auto transforms = next_->instantiate<tf2_msgs::TFMessage>()) {
        transforms_.publish(transforms);
      }
    }
    for (int i = 0; i < 10; ++i) {
      ros::spinOnce();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  /// Goes on until it is so; false when the drive ends before.
  bool until(const std::function<bool()>& is_so) {
    while (!is_so() && !is_at_end()) {
      go_on();
    }
    return is_so();
  }

  /// Waits for what has been published, at rest.
  static bool wait_until(const std::function<bool()>& is_so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!is_so() && std::chrono::steady_clock::now() < end) {
      ros::spinOnce();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return is_so();
  }

  /// Of the newest pose [s]; 0: none has come yet.
  [[nodiscard]] double newest() const { return found_.empty() ? 0.0 : found_.back().stamp; }
  [[nodiscard]] const std::vector<StampedPose2>& found() const { return found_; }

  /// The newest line of the node's log with these words.
  [[nodiscard]] std::string line(const std::string& words) const {
    for (auto line = log_.rbegin(); line != log_.rend(); ++line) {
      if (contains(*line, words)) {
        return *line;
      }
    }
    return "";
  }

 private:
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
    found_.push_back({message.header.stamp.toSec(), to_pose2(message.pose.pose)});
  }
  void on_log(const rosgraph_msgs::Log& message) { log_.push_back(message.msg); }

  ros::NodeHandle node_;
  ros::Publisher scans_ = node_.advertise<sensor_msgs::LaserScan>("/scan", 1000);
  ros::Publisher transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  ros::Subscriber poses_ = node_.subscribe("/pose", 1000, &Drive::on_pose, this);
  ros::Subscriber logs_ = node_.subscribe("/rosout", 1000, &Drive::on_log, this);
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator next_;
  std::vector<StampedPose2> found_;
  std::vector<std::string> log_;
};

/// What a node answers to a call of ROS's slave API; none: there is no such node.
std::optional<XmlRpc::XmlRpcValue> ask(const std::string& node, const char* method) {
  XmlRpc::XmlRpcValue arguments;
  XmlRpc::XmlRpcValue answer;
  XmlRpc::XmlRpcValue result;
  arguments[0] = "/test";
  arguments[1] = node;
  if (!ros::master::execute("lookupNode", arguments, answer, result, false)) {
    return std::nullopt;
  }
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(result, host, port);
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = "/test";
  if (!client.execute(method, caller, answer)) {
    return std::nullopt;
  }
  return answer[2];
}

/// The process of a node, as it says itself; 0: there is none.
int process_of(const std::string& node) {
  std::optional<XmlRpc::XmlRpcValue> process = ask(node, "getPid");
  return process ? static_cast<int>(*process) : 0;
}

/// Whether the lines of a node's log come here. What it logs before that is lost.
bool is_log_heard(const std::string& node) {
  std::optional<XmlRpc::XmlRpcValue> connections = ask(node, "getBusInfo");
  for (int i = 0; connections && i < connections->size(); ++i) {
    XmlRpc::XmlRpcValue& connection = (*connections)[i];
    if (std::string(connection[1]) == ros::this_node::getName() &&
        std::string(connection[2]) == "o" && std::string(connection[4]) == "/rosout") {
      return true;
    }
  }
  return false;
}

SimulatedRun simulate_drive(const std::string& bag) {
  SimulationOptions options;
  options.time.duration = 30.0;
  options.laser.beams = 360;
  const World world = make_world("rooms", 4);
  SimulatedRun run = simulate_run(world, world.route(), options, 4);
  SimulatedBagWriter(bag, {}).write(run, {"rooms", 4, options.laser, run.faults});
  return run;
}

Trajectory truth_of(const SimulatedRun& run) {
  std::vector<StampedPose2> poses;
  for (std::size_t k = 0; k < run.scans.size(); ++k) {
    poses.push_back({run.scans[k].stamp, run.world_from_base[k]});
  }
  return Trajectory(poses);
}

double occupied_cells(const MapImage& map) {
  int count = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      count += map.state({x, y}) == CellState::kOccupied ? 1 : 0;
    }
  }
  return count;
}

/// Tells when a file was replaced.
class FileWatch {
 public:
  explicit FileWatch(std::string path) : path_(std::move(path)) {}

  bool has_changed() {
    std::error_code ignored;
    const fs::file_time_type now = fs::last_write_time(path_, ignored);
    const bool changed = !ignored && now != last_;
    last_ = ignored ? last_ : now;
    return changed;
  }

 private:
  std::string path_;
  fs::file_time_type last_{};
};

TEST(SlamRespawn, KilledInTheMiddleOfADriveItGoesOnWithTheMapSavedLast) {
  const auto folder = ros::param::param<std::string>("~folder", "");
  ASSERT_NE(folder, "");
  require_writable_folder(folder);
  const SimulatedRun run = simulate_drive(folder + "/run.bag");
  Drive drive(folder + "/run.bag");
  ASSERT_TRUE(Drive::wait_until([&] { return drive.is_heard(); }));

  // What is saved was begun after what was saved before was there.
  FileWatch saved(folder + "/map.slam");
  double before_last = 0.0;
  double last = 0.0;
  ASSERT_TRUE(drive.until([&] {
    if (saved.has_changed()) {
      before_last = last;
      last = drive.newest();
    }
    return drive.found().size() > 200 && before_last > 0.0;
  }));
  const int process = process_of("/slam");
  ASSERT_GT(process, 0);
  ASSERT_EQ(::kill(process, SIGKILL), 0);
  const double killed = drive.newest();
  ASSERT_TRUE(Drive::wait_until([&] { return ::kill(process, 0) != 0; }));

  // The robot drives on meanwhile, for a while.
  const std::size_t before = drive.found().size();
  for (int i = 0; i < 20; ++i) {
    drive.go_on();
  }
  ASSERT_TRUE(Drive::wait_until([&] { return is_log_heard("/slam"); })) << "it does not come back";
  ASSERT_TRUE(drive.until([&] { return drive.found().size() > before; }))
      << "it does not come back";
  ASSERT_TRUE(drive.until([&] { return !drive.line("going on with ").empty(); }));
  const std::string told = drive.line("going on with ");
  const std::string words =
      "going on with " + folder + "/map.slam, whose drive goes on after its scan of ";
  ASSERT_EQ(told.substr(0, words.size()), words);
  const double resumed = std::stod(told.substr(words.size()));
  RecordProperty("lost_s", std::to_string(killed - resumed));
  RecordProperty("away_s", std::to_string(drive.found()[before].stamp - killed));
  EXPECT_GE(resumed, before_last) << "older than a period";
  EXPECT_TRUE(contains(told, " s with that of ")) << told;
  EXPECT_NE(process_of("/slam"), process);

  ASSERT_TRUE(drive.until([&] { return drive.is_at_end(); }));
  const double end = run.scans.back().stamp;
  ASSERT_TRUE(Drive::wait_until([&] { return drive.newest() > end - 0.2; }));
  std_srvs::Trigger save;
  ASSERT_TRUE(ros::service::call("/slam/save_map", save));
  ASSERT_TRUE(save.response.success) << save.response.message;

  // As if nothing had been: poses before and after are in one map, whose walls are single.
  const double error =
      absolute_trajectory_error(Trajectory(drive.found()), truth_of(run)).translation.rmse;
  const Outcome mapped =
      run_command(MATCHBOX_MAP_BAG, folder + "/run.bag --quiet --out " + folder + "/map_bag");
  ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
  const double walls = occupied_cells(read_map(folder + "/map.yaml")) /
                       occupied_cells(read_map(folder + "/map_bag/map.yaml"));
  RecordProperty("error_m", std::to_string(error));
  RecordProperty("walls", std::to_string(walls));
  EXPECT_LT(error, 0.0021);  // 0.0014 is measured
  EXPECT_LT(walls, 1.05);    // 1.02
  fs::remove_all(folder);
}

}  // namespace
}  // namespace matchbox_slam
