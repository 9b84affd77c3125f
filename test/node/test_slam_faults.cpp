// Of node/slam_node.hpp: the node when it is ended by a signal, when the disk is full, and when
// everybody wants something of it at once. The last is what the thread sanitizer looks at;
// CONTRIBUTING.md says how.

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/GetMap.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/Relocalise.h"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/slam_node.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

/// Looks again and again until it is so, or until it should long have been.
bool wait_until(const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!is_so() && std::chrono::steady_clock::now() < end) {
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return is_so();
}

/// A robot that creeps through a room. Its time goes on by steps, however long they take.
class Robot {
 public:
  Robot()
      : scans_(node_.advertise<sensor_msgs::LaserScan>("/scan", 10000)),
        transforms_(node_.advertise<tf2_msgs::TFMessage>("/tf", 10000)),
        poses_(node_.subscribe("/pose", 100, &Robot::on_pose, this)) {}

  [[nodiscard]] bool is_heard() const {
    return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0 &&
           poses_.getNumPublishers() > 0;
  }

  /// One scan and the transforms around it.
  void step(std::size_t beams = 90) {
    stamp_ += 0.05;
    scans_.publish(make_scan(stamp_, "laser", beams));
    for (const double stamp : {stamp_ - 0.01, stamp_ + 0.01}) {
      transforms_.publish(
          make_transforms({make_transform(stamp, "odom", "base", 0.5 * (stamp - begin_)),
                           make_transform(stamp, "base", "laser", 0.2)}));
    }
  }

  /// Time goes on, and the robot stands still.
  void rest(double seconds) {
    stamp_ += seconds;
    begin_ += seconds;
  }

  /// Steps until this many more poses came back.
  bool drive(int poses) {
    const int wanted = poses_heard_ + poses;
    return wait_until([&] {
      if (poses_heard_ < wanted) {
        step();
      }
      return poses_heard_ >= wanted;
    });
  }

 private:
  static constexpr double kBegin = 1000.0;

  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& /*message*/) { ++poses_heard_; }

  ros::NodeHandle node_;
  ros::Publisher scans_;
  ros::Publisher transforms_;
  ros::Subscriber poses_;
  double begin_ = kBegin;  ///< from where on it would have driven without a rest
  double stamp_ = kBegin;
  std::atomic<int> poses_heard_{0};
};

/// A program, killed with this object at the latest.
class Process {
 public:
  explicit Process(const std::vector<std::string>& arguments) {
    std::vector<char*> pointers;
    for (const std::string& argument : arguments) {
      pointers.push_back(const_cast<char*>(argument.c_str()));
    }
    pointers.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
      std::signal(SIGXFSZ, SIG_IGN);  // so that writing fails instead, as on a disk that is full
      ::execvp(pointers[0], pointers.data());
      ::_exit(127);
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (!status_) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }

  void set_largest_file(rlim_t bytes) const {
    const rlimit limit{bytes, RLIM_INFINITY};
    ASSERT_EQ(::prlimit(pid_, RLIMIT_FSIZE, &limit, nullptr), 0);
  }

  /// What it exits with after a signal; -1 when it does not, or dies of it.
  int exit_code_after(int signal) {
    ::kill(pid_, signal);
    wait_until([&] {
      int status = 0;
      if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) {
        status_ = status;
      }
      return status_.has_value();
    });
    return status_ && WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -1;
  }

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

/// slam_node as a process of its own, in which no file can be too large but by `set_largest_file`.
class NodeProcess : public Process {
 public:
  NodeProcess(const std::string& name, const TemporaryFolder& folder,
              const std::vector<std::string>& more_arguments = {})
      : Process([&] {
          std::vector<std::string> arguments = {MATCHBOX_SLAM_NODE,
                                                "__name:=" + name,
                                                "_base_frame:=base",
                                                "_trajectory_file:=" + (folder / "node.tum"),
                                                "_map_file:=" + (folder / "map"),
                                                "_slam/insert_distance:=0"};
          arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
          return arguments;
        }()) {}
};

TEST(SlamFaults, ASignalEndsItWithTheTrajectorySaved) {
  Robot robot;
  for (const int signal : {SIGINT, SIGTERM}) {
    const TemporaryFolder folder;
    NodeProcess process("signalled", folder);
    ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
    ASSERT_TRUE(robot.drive(20));
    EXPECT_EQ(process.exit_code_after(signal), 0) << signal;
    EXPECT_GE(read_tum(folder / "node.tum").size(), 20U) << signal;
    EXPECT_EQ(folder.file_count(), 1U) << "nothing half written is left";
    ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
  }
}

/// Whether a master of its own, at this port, knows the node.
bool is_known(const std::string& node, int port) {
  XmlRpc::XmlRpcClient master("127.0.0.1", port, "/");
  XmlRpc::XmlRpcValue arguments;
  arguments[0] = "/test";
  arguments[1] = node;
  XmlRpc::XmlRpcValue answer;
  return master.execute("lookupNode", arguments, answer) && static_cast<int>(answer[0]) == 1;
}

TEST(SlamFaults, ASignalEndsItAlsoWhenTheMasterIsGone) {
  const int port = 20000 + ::getpid() % 10000;
  const TemporaryFolder folder;
  // While it starts, and when it would tell that no scan has come, 5 s later.
  for (const int seconds : {0, 3}) {
    Process master({"rosmaster", "--core", "-p", std::to_string(port)});
    NodeProcess process("orphan", folder, {"__master:=http://127.0.0.1:" + std::to_string(port)});
    ASSERT_TRUE(wait_until([&] { return is_known("/orphan", port); }));
    std::this_thread::sleep_for(std::chrono::seconds(seconds));
    (void)master.exit_code_after(SIGKILL);
    std::this_thread::sleep_for(std::chrono::seconds(4));
    EXPECT_EQ(process.exit_code_after(SIGINT), 0) << seconds;
  }
}

/// Sends scans of which half the beams read what they read where they meet nothing, from when a
/// file `go` is in the folder on; `ready` tells that it is heard, `done` that it has sent all.
constexpr const char* kFarScans = R"(
import os, sys, time
import rospy
from sensor_msgs.msg import LaserScan
folder = sys.argv[1]
def tell(name):
    open(os.path.join(folder, name), "w").close()
rospy.init_node("far_scans")
scans = rospy.Publisher("scan", LaserScan, queue_size=100)
while scans.get_num_connections() == 0:
    time.sleep(0.05)
tell("ready")
while not os.path.exists(os.path.join(folder, "go")):
    time.sleep(0.05)
for k in range(60):
    scan = LaserScan(angle_min=-1.5, angle_increment=0.03, range_min=0.1, range_max=30.0)
    scan.header.frame_id = "base"
    scan.header.stamp = rospy.Time(1000.0 + 0.05 * k)
    scan.ranges = [29.99, 3.0] * 50
    scans.publish(scan)
    time.sleep(0.05)
tell("done")
time.sleep(600.0)
)";

TEST(SlamFaults, CutsBeamsAlsoWhenTheMasterIsGone) {
  const int port = 20000 + (::getpid() + 5000) % 10000;
  const std::string uri = "http://127.0.0.1:" + std::to_string(port);
  const TemporaryFolder folder;
  const TemporaryFolder signs;
  Process master({"rosmaster", "--core", "-p", std::to_string(port)});
  NodeProcess process("orphan", folder,
                      {"__master:=" + uri, "_use_odometry:=false", "_resume:=true"});
  ASSERT_TRUE(wait_until([&] { return is_known("/orphan", port); }));
  const Process scans(
      {"env", "ROS_MASTER_URI=" + uri, "/usr/bin/python3", "-c", kFarScans, signs.path()});
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(signs / "ready"); }));
  (void)master.exit_code_after(SIGKILL);
  replace_file(signs / "go", "");
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(signs / "done"); }));
  EXPECT_EQ(process.exit_code_after(SIGINT), 0) << "it waits for a master";
  EXPECT_GE(read_tum(folder / "node.tum").size(), 20U);
}

/// The last of the log lines that hold these words; empty while there is none. To be made before
/// the node that is listened to.
class LogWatch {
 public:
  explicit LogWatch(std::string words) : words_(std::move(words)) {
    EXPECT_TRUE(wait_until([this] { return log_.getNumPublishers() > 0; }));  // this program's
    before_ = log_.getNumPublishers();
  }

  [[nodiscard]] std::string line() const { return line_; }

  /// Waits until the node is heard: what it says before is lost, but for its newest line.
  [[nodiscard]] bool hears_the_node() const {
    return wait_until([this] { return log_.getNumPublishers() > before_; });
  }

 private:
  void on_log(const rosgraph_msgs::Log& log) {
    if (contains(log.msg, words_)) {
      line_ = log.msg;
    }
  }

  ros::NodeHandle node_;
  std::string words_;
  std::string line_;
  ros::Subscriber log_ = node_.subscribe("/rosout", 1000, &LogWatch::on_log, this);
  std::uint32_t before_ = 0;
};

TEST(SlamFaults, AnotherLocaliserIsNamedAndOurselvesAreNot) {
  Robot robot;
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
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamFaults, AStopAtAJumpOfTimeSaysHowToGoOn) {
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

TEST(SlamFaults, ASecondOdometryIsToldInTheLogAndByDiagnostics) {
  Robot robot;
  LogWatch log("two nodes publish tf from the odometry frame 'odom': ");
  const DiagnosticsWatch diagnostics;
  const TemporaryFolder folder;
  NodeProcess process("of_two_odometries", folder);
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(20));
  EXPECT_EQ(log.line(), "");
  Process other({"rostopic", "pub", "-r", "20", "/tf", "tf2_msgs/TFMessage",
                 "{transforms: [{header: {frame_id: odom, stamp: {secs: 1000}}, child_frame_id: "
                 "cart, transform: {rotation: {w: 1}}}]}"});
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

TEST(SlamFaults, ANodeletThatIsEndedSaysThatItsMapIsNotSaved) {
  Robot robot;
  const TemporaryFolder folder;
  Process manager({"bash", "-c",
                   "exec rosrun nodelet nodelet standalone matchbox_slam/SlamNodelet "
                   "__name:=lone_nodelet _base_frame:=base 2>" +
                       (folder / "said")});
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(20));
  EXPECT_EQ(manager.exit_code_after(SIGINT), 0);
  const std::string said = read_file(folder / "said");
  EXPECT_TRUE(contains(said,
                       " scans is not saved. Before the end, rosservice call "
                       "/lone_nodelet/save_map saves it"))
      << said;
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamFaults, StartedAgainAfterALongPauseItGoesOnWhereOdometryHasIt) {
  Robot robot;
  const TemporaryFolder folder;
  const std::vector<std::string> resume = {"_resume:=true", "_autosave_period:=0.5"};
  {
    NodeProcess process("of_a_pause", folder, resume);
    ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
    ASSERT_TRUE(robot.drive(60));
    EXPECT_EQ(process.exit_code_after(SIGINT), 0);
    ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
  }
  robot.rest(300.0);
  LogWatch log("going on with ");
  NodeProcess process("of_a_pause", folder, resume);
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(5));
  ASSERT_TRUE(wait_until([&] { return !log.line().empty(); }));
  EXPECT_TRUE(contains(log.line(), " s with that of ")) << log.line();
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

TEST(SlamFaults, EachScanSendsTheTransform) {
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

TEST(SlamFaults, TheTransformIsRepeatedWhileNoScanComes) {
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

std_srvs::Trigger::Response save(const std::string& node) {
  std_srvs::Trigger service;
  EXPECT_TRUE(ros::service::call("/" + node + "/save_map", service));
  return service.response;
}

TEST(SlamFaults, NamesWhatIsNoScan) {
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

TEST(SlamFaults, CutsBeamsThatReadTheLargestRangePlusNoise) {
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

/// Scans that the node says it has received.
class Received {
 public:
  [[nodiscard]] int count() const { return count_; }

 private:
  void on_diagnostics(const diagnostic_msgs::DiagnosticArray& array) {
    for (const auto& status : array.status) {
      for (const auto& value : status.values) {
        count_ = value.key == "Scans received" ? std::stoi(value.value) : count_;
      }
    }
  }

  ros::NodeHandle node_;
  int count_ = 0;
  ros::Subscriber diagnostics_ =
      node_.subscribe("/diagnostics", 10, &Received::on_diagnostics, this);
};

TEST(SlamFaults, ASignalWaitsForNoScanThatIsQueuedAndAllAreCounted) {
  constexpr int kScans = 3000;
  Robot robot;
  LogWatch log("mapping has ended: ");
  Received received;
  const TemporaryFolder folder;
  NodeProcess process(
      "backlogged", folder,
      {"_queue_size:=10000", "_matcher:=monte_carlo", "_monte_carlo/max_tries:=200000",
       "_monte_carlo/max_failed_tries:=200000"});  // some 300 ms a match
  ASSERT_TRUE(log.hears_the_node());
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  for (int k = 0; k < kScans; ++k) {
    robot.step(1040);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(wait_until([&] { return received.count() >= kScans; })) << received.count();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(took.count(), 5.0) << "2 s are asked for; this machine may be busy";
  ::testing::Test::RecordProperty("seconds", std::to_string(took.count()));
  const std::size_t used = read_tum(folder / "node.tum").size();
  EXPECT_GT(used, 0U);
  EXPECT_LT(used, kScans / 2U) << "there was no backlog";
  const std::size_t left_out = kScans - used;
  ASSERT_TRUE(wait_until([&] { return !log.line().empty(); }));
  EXPECT_EQ(log.line(), "mapping has ended: " + std::to_string(kScans) + " scans received, " +
                            std::to_string(used) + " used, " + std::to_string(left_out) +
                            " skipped (interrupted: " + std::to_string(left_out) + ")");
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

/// Hears scans after all who have subscribed before: what has come here has come to them, too.
class LastListener {
 public:
  LastListener() {
    node_.setCallbackQueue(&callbacks_);
    scans_ = node_.subscribe("/scan", 1000, &LastListener::on_scan, this);
  }

  [[nodiscard]] bool hears(int scans) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (heard_ < scans && std::chrono::steady_clock::now() < end) {
      callbacks_.callAvailable(ros::WallDuration(0.05));
    }
    return heard_ >= scans;
  }

 private:
  void on_scan(const sensor_msgs::LaserScan& /*message*/) { ++heard_; }

  ros::CallbackQueue callbacks_;
  ros::NodeHandle node_;
  ros::Subscriber scans_;
  int heard_ = 0;
};

TEST(SlamFaults, ScansThatNobodyHasTakenFromRoscppsBuffersAreCountedAtItsEnd) {
  Robot robot;
  LogWatch log("mapping has ended");
  ros::param::set("/unread/base_frame", "base");
  {
    const SlamNode slam(ros::NodeHandle(), ros::NodeHandle("/unread"));
    ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
    LastListener listener;
    for (int i = 0; i < 20; ++i) {  // which wait, since nobody spins
      robot.step();
    }
    ASSERT_TRUE(listener.hears(20));  // a thread of roscpp carries them, so it takes a while
  }
  ASSERT_TRUE(wait_until([&] { return !log.line().empty(); }));
  EXPECT_EQ(log.line(),
            "mapping has ended: 20 scans received, 0 used, 20 skipped (interrupted: 20)");
}

TEST(SlamFaults, AFullDiskLeavesTheOldMapAndTheMapping) {
  Robot robot;
  const TemporaryFolder folder;
  NodeProcess process("on_full_disk", folder);
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(3));
  const std::string new_folder = folder / "new/folder";
  dynamic_reconfigure::Reconfigure elsewhere;
  elsewhere.request.config.strs.resize(1);
  elsewhere.request.config.strs[0].name = "map_file";
  elsewhere.request.config.strs[0].value = new_folder + "/map";
  ASSERT_TRUE(ros::service::call("/on_full_disk/set_parameters", elsewhere));
  EXPECT_TRUE(save("on_full_disk").success) << "the folder is made";
  EXPECT_TRUE(read_file(new_folder + "/map.yaml").size() > 0);
  std::filesystem::remove_all(folder / "new");
  elsewhere.request.config.strs[0].value = folder / "map";
  ASSERT_TRUE(ros::service::call("/on_full_disk/set_parameters", elsewhere));
  ASSERT_TRUE(save("on_full_disk").success);
  const std::vector<std::string> names = {"map.pgm", "map.yaml", "map.png", "node.tum", "map.slam"};
  std::vector<std::string> old;
  for (const std::string& name : names) {
    old.push_back(read_file(folder / name));
  }
  ASSERT_TRUE(robot.drive(30));
  process.set_largest_file(200);  // less than an image, more than the YAML
  const std_srvs::Trigger::Response refused = save("on_full_disk");
  EXPECT_FALSE(refused.success);
  EXPECT_TRUE(
      contains(refused.message, "cannot write '" + (folder / "map.pgm") + "': File too large"))
      << refused.message;
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_TRUE(read_file(folder / names[i]) == old[i]) << names[i];
  }
  EXPECT_EQ(folder.file_count(), names.size());
  ASSERT_TRUE(robot.drive(3));
  process.set_largest_file(RLIM_INFINITY);
  EXPECT_TRUE(save("on_full_disk").success);
  EXPECT_FALSE(read_file(folder / "node.tum") == old[3]);
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

/// What the node's diagnostics say in a line.
class Summary {
 public:
  [[nodiscard]] const diagnostic_msgs::DiagnosticStatus& now() const { return status_; }

 private:
  void on_diagnostics(const diagnostic_msgs::DiagnosticArray& array) {
    for (const auto& status : array.status) {
      if (contains(status.name, "SLAM")) {
        status_ = status;
      }
    }
  }

  ros::NodeHandle node_;
  diagnostic_msgs::DiagnosticStatus status_;
  ros::Subscriber diagnostics_ =
      node_.subscribe("/diagnostics", 10, &Summary::on_diagnostics, this);
};

TEST(SlamFaults, AnAutosaveThatFailsIsAnErrorUntilItWorks) {
  Robot robot;
  Summary summary;
  const TemporaryFolder folder;
  NodeProcess process("autosaving_on_full_disk", folder, {"_autosave_period:=0.3"});
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  ASSERT_TRUE(robot.drive(3));
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "map.slam"); }));
  process.set_largest_file(20);
  const auto says = [&](const std::string& words) {
    return wait_until([&] { return robot.drive(1) && contains(summary.now().message, words); });
  };
  EXPECT_TRUE(says("the map is not saved: cannot write")) << summary.now().message;
  EXPECT_EQ(summary.now().level, diagnostic_msgs::DiagnosticStatus::ERROR);
  process.set_largest_file(RLIM_INFINITY);
  EXPECT_TRUE(says("mapping")) << summary.now().message;
  EXPECT_EQ(process.exit_code_after(SIGINT), 0);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamFaults, AnAutosaveWritesWhatHasChanged) {
  Robot robot;
  const TemporaryFolder folder;
  NodeProcess process("autosaving", folder, {"_autosave_period:=0.1"});
  ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
  const std::string file = folder / "map.slam";
  ASSERT_TRUE(wait_until([&] {
    return robot.drive(1) && std::filesystem::exists(file + ".changes");
  })) << "it always writes all";
  EXPECT_EQ(process.exit_code_after(SIGKILL), -1);
  const EngineState with_changes = read_saved_map(file);
  std::filesystem::remove(file + ".changes");
  EXPECT_GT(with_changes.scan_count, read_saved_map(file).scan_count);
  ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
}

TEST(SlamFaults, AMapThatIsNotGoneOnWithIsKept) {
  Robot robot;
  const TemporaryFolder folder;
  const std::string file = folder / "map.slam";
  std::string first;
  for (const std::string resume : {"true", "true", "false"}) {
    NodeProcess process("session", folder, {"_autosave_period:=100", "_resume:=" + resume});
    ASSERT_TRUE(wait_until([&] { return robot.is_heard(); }));
    ASSERT_TRUE(robot.drive(5));
    EXPECT_EQ(process.exit_code_after(SIGINT), 0);
    ASSERT_TRUE(wait_until([&] { return !robot.is_heard(); }));
    if (resume == "true") {
      EXPECT_FALSE(std::filesystem::exists(file + ".1")) << "it went on with the map";
      first = read_file(file);
    }
  }
  ASSERT_TRUE(std::filesystem::exists(file + ".1"));
  EXPECT_TRUE(read_file(file + ".1") == first);
  EXPECT_FALSE(read_file(file) == first);
}

dynamic_reconfigure::Reconfigure choose(const std::string& matcher, double tolerance) {
  dynamic_reconfigure::Reconfigure service;
  service.request.config.strs.resize(1);
  service.request.config.strs[0].name = "matcher";
  service.request.config.strs[0].value = matcher;
  service.request.config.doubles.resize(1);
  service.request.config.doubles[0].name = "transform_tolerance";
  service.request.config.doubles[0].value = tolerance;
  return service;
}

/// Threads that all want something of the node, until they are told to stop.
class Crowd {
 public:
  /// @param map  where ~save_map puts it, for ~load_map.
  Crowd(const std::string& node, const std::string& map) {
    call_again_and_again<std_srvs::Trigger>("/" + node + "/save_map", {});
    call_again_and_again<std_srvs::Trigger>("/" + node + "/reset", {});
    call_again_and_again<nav_msgs::GetMap>("/dynamic_map", {});
    std_srvs::SetBool pause;
    pause.request.data = 1;
    call_again_and_again("/" + node + "/pause", pause);
    pause.request.data = 0;
    call_again_and_again("/" + node + "/pause", pause);
    Relocalise relocalise;
    relocalise.request.scan = make_scan(1.0);
    call_again_and_again("/" + node + "/relocalise", relocalise);
    call_again_and_again("/" + node + "/set_parameters", choose("hough", 0.0));
    call_again_and_again("/" + node + "/set_parameters", choose("olson", 0.1));
    LoadMap load;
    load.request.path = map + ".slam";
    call_again_and_again("/" + node + "/load_map", load);
    threads_.emplace_back([this] { tell_poses(); });
  }
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;
  ~Crowd() {
    stop_ = true;
    for (std::thread& thread : threads_) {
      thread.join();
    }
  }

  /// Calls that were answered by every service at least.
  [[nodiscard]] int answered() const {
    int least = answers_[0];
    for (std::size_t i = 1; i < services_; ++i) {
      least = std::min<int>(least, answers_[i]);
    }
    return least;
  }

  /// The answers of each, for people.
  [[nodiscard]] std::string account() const {
    std::string text;
    for (std::size_t i = 0; i < services_; ++i) {
      text += names_[i] + ": " + std::to_string(answers_[i]) + " answers\n";
    }
    return text;
  }

 private:
  template <typename Service>
  void call_again_and_again(const std::string& name, const Service& service) {
    names_[services_] = name;
    threads_.emplace_back([this, name, service, &answers = answers_[services_++]] {
      while (!stop_) {
        Service call = service;
        answers += ros::service::call(name, call) ? 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
  }

  void tell_poses() {
    ros::NodeHandle node;
    ros::Publisher poses =
        node.advertise<geometry_msgs::PoseWithCovarianceStamped>("/initialpose", 10);
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.frame_id = "map";
    message.pose.pose.orientation.w = 1.0;
    while (!stop_) {
      poses.publish(message);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  std::atomic<bool> stop_{false};
  std::array<std::string, 9> names_;
  std::array<std::atomic<int>, 9> answers_{};
  std::size_t services_ = 0;
  std::vector<std::thread> threads_;
};

/// How often the crowd is served before the node goes: a little in every test run.
int stress_rounds() {
  const char* text = std::getenv("MATCHBOX_STRESS_ROUNDS");
  return text != nullptr ? std::atoi(text) : 10;
}

TEST(SlamFaults, ServesACrowdAndMapsOn) {
  const TemporaryFolder folder;
  ros::param::set("/crowded/base_frame", "base");
  ros::param::set("/crowded/map_file", folder / "map");
  ros::param::set("/crowded/trajectory_file", folder / "node.tum");
  ros::param::set("/crowded/map_update_interval", 0.05);
  ros::param::set("/crowded/slam/insert_distance", 0.0);
  Robot robot;
  std::atomic<int> maps{0};
  ros::NodeHandle node;
  const ros::Subscriber subscriber = node.subscribe<nav_msgs::OccupancyGrid>(
      "/map", 1, [&](const nav_msgs::OccupancyGridConstPtr& /*map*/) { ++maps; });
  ros::AsyncSpinner spinner(3);  // as in a manager: callbacks of one node at the same time
  spinner.start();
  for (int life = 0; life < 2; ++life) {
    auto slam = std::make_unique<SlamNode>(ros::NodeHandle(), ros::NodeHandle("/crowded"));
    std::optional<Crowd> crowd(std::in_place, "crowded", folder / "map");
    ASSERT_TRUE(wait_until([&] {
      robot.step();
      return crowd->answered() >= stress_rounds();
    })) << "a service does not answer:\n"
        << crowd->account();
    if (life == 0) {
      slam.reset();  // while they all still call
    }
    crowd.reset();
    if (slam != nullptr) {
      std_srvs::SetBool go_on;
      ASSERT_TRUE(ros::service::call("/crowded/pause", go_on));
      EXPECT_TRUE(robot.drive(5)) << "it does not map any more";
    }
  }
  EXPECT_GT(maps, 0);
  EXPECT_GT(read_tum(folder / "node.tum").size(), 0U);
}

}  // namespace
}  // namespace matchbox_slam

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "test_slam_faults");
  const ros::NodeHandle keeps_ros_alive;
  return RUN_ALL_TESTS();
}
