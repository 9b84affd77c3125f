// Of node/slam_node.hpp: the node when it is ended by a signal, and when the disk is full.

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Trigger.h>
#include <sys/resource.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpc.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/node_process.hpp"
#include "node/slam_node.hpp"

namespace matchbox_slam {
namespace {

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
                       " are not saved. Before the end, rosservice call "
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
  EXPECT_FALSE(read_file(new_folder + "/map.yaml").empty());
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

}  // namespace
}  // namespace matchbox_slam
