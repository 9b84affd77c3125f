// Of node/slam_node.hpp: plays a simulated bag into the nodelet and compares what it publishes with
// the truth and with what map_bag makes of the same bag.

#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <nav_msgs/GetMap.h>
#include <nodelet/NodeletLoad.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <rosgraph_msgs/Clock.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "common/version.hpp"
#include "io/gzip.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/Relocalise.h"
#include "matchbox_slam/SetPoseAtStamp.h"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/node_process.hpp"
#include "node/slam_listener.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

/// The bag is simulated, mapped by map_bag and played into the node once for all tests.
class SlamNodelet : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = ros::param::param<std::string>("~folder", "");
    ASSERT_NE(folder_, "");
    require_writable_folder(folder_);
    simulate();
    const Outcome mapped = run_command(
        MATCHBOX_MAP_BAG, folder_ + "/run.bag --quiet --out " + folder_ + "/map_bag --config " +
                              MATCHBOX_SOURCE_DIR + "/config/olson.yaml");
    ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
    listener_ = std::make_unique<SlamListener>();
    play();
  }

  static void TearDownTestSuite() {
    listener_.reset();
    std::filesystem::remove_all(folder_);
  }

  static std_srvs::Trigger::Response call(const std::string& service) {
    std_srvs::Trigger trigger;
    EXPECT_TRUE(ros::service::call(service, trigger)) << service;
    return trigger.response;
  }

  static std::string value_of(const std::string& name) { return listener_->value_of(name); }

  static std::string folder_;
  static std::vector<Pose2> truth_;  ///< of the base in the map
  static std::unique_ptr<SlamListener> listener_;

 private:
  static void simulate() {
    SimulationOptions options;
    options.time.duration = 20.0;
    options.laser.time_increment = 2e-5;
    const World world = make_world("rooms", 4);
    const SimulatedRun run = simulate_run(world, world.route(), options, 4);
    SimulatedBagWriter(folder_ + "/run.bag", {})
        .write(run, {"rooms", 4, options.laser, run.faults});
    for (const Pose2& pose : run.world_from_base) {
      truth_.push_back(run.world_from_base.front().inverse() * pose);
    }
  }

  static void play() {
    auto played = std::async(std::launch::async, [] {
      return run_command("rosbag",
                         "play --quiet --clock --queue=100000 --delay=1 --wait-for-subscribers "
                         "--rate=3 " +
                             folder_ + "/run.bag --topics /base_scan /tf /tf_static");
    });
    const std::size_t expected = read_tum(folder_ + "/map_bag/trajectory.tum").size();
    EXPECT_TRUE(listener_->wait_until([&] { return listener_->poses.size() >= expected; }, 60.0));
    EXPECT_EQ(played.get().exit_code, 0);
    // The last map and paths, and a tick of the diagnostics.
    listener_->wait_until([] { return false; }, 3.0);
  }
};

std::string SlamNodelet::folder_;
std::vector<Pose2> SlamNodelet::truth_;
std::unique_ptr<SlamListener> SlamNodelet::listener_;

TEST_F(SlamNodelet, ATrajectoryLikeMapBagsByteByByte) {
  const std_srvs::Trigger::Response saved = call("/slam/save_map");
  ASSERT_TRUE(saved.success) << saved.message;
  EXPECT_TRUE(contains(saved.message, folder_ + "/node_map.pgm")) << saved.message;
  // Not EXPECT_EQ, which would print both files.
  EXPECT_TRUE(read_file(folder_ + "/node.tum") == read_file(folder_ + "/map_bag/trajectory.tum"));
  EXPECT_TRUE(read_file(folder_ + "/node_map.pgm") == read_file(folder_ + "/map_bag/map.pgm"));
  EXPECT_GT(std::filesystem::file_size(folder_ + "/node_map.png"), 1000U);
}

/// A scan of the recording by its number.
sensor_msgs::LaserScan recorded_scan(const std::string& bag_file, std::size_t number) {
  const rosbag::Bag bag(bag_file, rosbag::bagmode::Read);
  std::size_t count = 0;
  for (const rosbag::MessageInstance& message :
       rosbag::View(bag, rosbag::TopicQuery(std::string("/base_scan")))) {
    if (count++ == number) {
      return *message.instantiate<sensor_msgs::LaserScan>();
    }
  }
  return {};
}

TEST_F(SlamNodelet, RelocalisesAScanAmongItsKeyScans) {
  const std::size_t number = truth_.size() / 2;
  Relocalise service;
  service.request.scan = recorded_scan(folder_ + "/run.bag", number);
  ASSERT_TRUE(ros::service::call("/slam/relocalise", service));
  ASSERT_FALSE(service.response.poses.empty()) << service.response.message;
  EXPECT_EQ(service.response.scores.size(), service.response.poses.size());
  const Pose2 best = to_pose2(service.response.poses.front());
  EXPECT_NEAR(best.x, truth_[number].x, 0.05);
  EXPECT_NEAR(best.y, truth_[number].y, 0.05);
  EXPECT_NEAR(wrap_angle(best.theta - truth_[number].theta), 0.0, 0.02);
  EXPECT_GT(service.response.ratio, 1.0);
  service.request.scan.angle_increment = 0.0F;
  ASSERT_TRUE(ros::service::call("/slam/relocalise", service));
  EXPECT_TRUE(service.response.poses.empty());
  EXPECT_TRUE(contains(service.response.message, "cannot be used")) << service.response.message;
}

TEST_F(SlamNodelet, GoesOnFromWhereItRelocalises) {
  ros::NodeHandle node;
  ros::Publisher told = node.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 1);
  ASSERT_TRUE(listener_->wait_until([&] { return told.getNumSubscribers() > 0; }, 10.0));
  const auto distance_from_truth = [] {
    EXPECT_TRUE(call("/slam/save_map").success);
    const Pose2 believed = read_saved_map(folder_ + "/node_map.slam").motion.fixed_from_base;
    return (believed.translation() - truth_.back().translation()).norm();
  };
  EXPECT_LT(distance_from_truth(), 0.05);
  geometry_msgs::PoseWithCovarianceStamped wrong;
  wrong.header.frame_id = "map";
  wrong.pose.pose = to_pose_message(truth_.back() * Pose2{1.5, 1.0, 2.0});
  told.publish(wrong);
  EXPECT_TRUE(listener_->wait_until([&] { return distance_from_truth() > 1.0; }, 10.0));
  Relocalise service;  // the newest scan
  service.request.set_pose = 1;
  ASSERT_TRUE(ros::service::call("/slam/relocalise", service));
  EXPECT_TRUE(service.response.pose_set) << service.response.message;
  EXPECT_LT(distance_from_truth(), 0.05);
  // Where a scan of some other time was taken says nothing of where the robot is now.
  service.request.scan = recorded_scan(folder_ + "/run.bag", 0);
  ASSERT_TRUE(ros::service::call("/slam/relocalise", service));
  EXPECT_FALSE(service.response.pose_set);
  EXPECT_TRUE(contains(service.response.message, "not the newest")) << service.response.message;
}

TEST_F(SlamNodelet, TakesAPlaceForAScanThatItUsedAlone) {
  SetPoseAtStamp service;
  service.request.stamp = listener_->poses.back().header.stamp;
  service.request.pose = to_pose_message(truth_.back());
  ASSERT_TRUE(ros::service::call("/slam/set_pose_at_stamp", service));
  EXPECT_TRUE(service.response.success) << service.response.message;
  service.request.stamp -= ros::Duration(0.01);  // between two scans
  ASSERT_TRUE(ros::service::call("/slam/set_pose_at_stamp", service));
  EXPECT_FALSE(service.response.success);
  EXPECT_TRUE(contains(service.response.message, "no scan of")) << service.response.message;
  service.request.stamp = listener_->poses.back().header.stamp;
  service.request.pose.position.x = std::nan("");
  ASSERT_TRUE(ros::service::call("/slam/set_pose_at_stamp", service));
  EXPECT_FALSE(service.response.success);
  EXPECT_TRUE(contains(service.response.message, "its position is no")) << service.response.message;
}

TEST_F(SlamNodelet, PosesAreTrue) {
  const auto& poses = listener_->poses;
  ASSERT_EQ(poses.size(), truth_.size()) << "every scan is used";
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Pose2 error = truth_[k].inverse() * to_pose2(poses[k].pose.pose);
    EXPECT_LT(std::hypot(error.x, error.y), 0.05) << k;
    EXPECT_LT(std::abs(error.theta), 0.02) << k;
    EXPECT_EQ(poses[k].header.frame_id, "map");
  }
  EXPECT_GT(poses.back().pose.covariance[0], 0.0);
  EXPECT_GT(poses.back().pose.covariance[35], 0.0);
}

TEST_F(SlamNodelet, TransformsLeadToTheSamePose) {
  const auto& last = listener_->poses.back();
  const auto map_from_base =
      listener_->transforms.lookup("map", "base_footprint", last.header.stamp);
  ASSERT_TRUE(map_from_base);
  const Pose2 error = to_pose2(last.pose.pose).inverse() * project_to_plane(*map_from_base);
  EXPECT_LT(std::hypot(error.x, error.y), 0.02);
  ASSERT_GT(listener_->leads.size(), 100U);
  std::vector<ros::Duration> leads = listener_->leads;
  std::nth_element(leads.begin(), leads.begin() + static_cast<std::ptrdiff_t>(leads.size() / 2),
                   leads.end());
  EXPECT_NEAR(leads[leads.size() / 2].toSec(), 0.1, 0.05) << "stamped ahead by the tolerance";
}

TEST_F(SlamNodelet, TheLatchedMapIsMapBags) {
  const nav_msgs::OccupancyGrid map = listener_->latched_map();
  const MapImage image = read_map(folder_ + "/map_bag/map.yaml");
  ASSERT_EQ(static_cast<int>(map.info.width), image.width);
  ASSERT_EQ(static_cast<int>(map.info.height), image.height);
  EXPECT_NEAR(map.info.origin.position.x, image.origin.x, 1e-9);
  EXPECT_NEAR(map.info.origin.position.y, image.origin.y, 1e-9);
  EXPECT_EQ(map.header.frame_id, "map");
  EXPECT_FALSE(map.header.stamp.isZero());
  std::size_t occupied = 0;
  std::size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::int8_t value = map.data[i++];
      occupied += value > 65 ? 1U : 0U;
      if (value > 65) {
        ASSERT_EQ(image.state({x, y}), CellState::kOccupied) << x << " " << y;
      } else if (value == -1) {
        ASSERT_EQ(image.state({x, y}), CellState::kUnknown) << x << " " << y;
      } else if (value < 19) {
        ASSERT_EQ(image.state({x, y}), CellState::kFree) << x << " " << y;
      }
    }
  }
  EXPECT_GT(occupied, 300U);
  nav_msgs::GetMap service;
  ASSERT_TRUE(ros::service::call("/dynamic_map", service));
  EXPECT_EQ(service.response.map.data, map.data);
}

TEST_F(SlamNodelet, TellsOfEveryMatch) {
  const auto& matches = listener_->matches;
  ASSERT_EQ(matches.size(), listener_->poses.size());
  EXPECT_EQ(matches.front().status, "rejected_no_reference");
  EXPECT_TRUE(matches.front().inserted);
  const MatchInfo& last = matches.back();
  EXPECT_EQ(last.header.stamp, listener_->poses.back().header.stamp);
  EXPECT_EQ(last.header.frame_id, "map");
  EXPECT_EQ(last.matcher, "matchbox_slam/Olson");
  EXPECT_EQ(last.status, "accepted");
  EXPECT_GT(last.score, 0.5);
  EXPECT_TRUE(last.proven);
  EXPECT_FALSE(last.window_clipped);
  EXPECT_FALSE(last.on_edge);
  EXPECT_GT(std::abs(last.refined_by.x), 0.0);
  EXPECT_LT(std::abs(last.refined_by.x), 0.05);
  EXPECT_GT(last.candidates, 0U);
  EXPECT_GT(last.match_time, 0.0);
  EXPECT_NEAR(last.pose.x, listener_->poses.back().pose.pose.position.x, 1e-9);
  EXPECT_NEAR(last.predicted.x, last.pose.x, 0.1);
}

TEST_F(SlamNodelet, DrawsBothTrajectories) {
  ASSERT_GT(listener_->path.poses.size(), truth_.size() / 5);
  ASSERT_GT(listener_->odometry_path.poses.size(), truth_.size() / 5);
  EXPECT_EQ(listener_->path.poses.back().pose, listener_->poses.back().pose.pose);
  EXPECT_EQ(listener_->odometry_path.header.frame_id, "map");
  EXPECT_NEAR(listener_->odometry_path.poses.front().pose.position.x, 0.0, 1e-6);
}

TEST_F(SlamNodelet, DiagnosticsTellWhatBecameOfTheScans) {
  ASSERT_FALSE(listener_->status.name.empty());
  EXPECT_EQ(value_of("Scans received"), std::to_string(truth_.size()));
  EXPECT_EQ(value_of("Scans used"), std::to_string(truth_.size()));
  EXPECT_NEAR(std::stod(value_of("Scan rate [Hz]")), 20.0, 0.2);
  EXPECT_EQ(value_of("Match"), "accepted");
}

TEST_F(SlamNodelet, ANodeThatCannotStartSaysWhyAndExits) {
  const auto refused = [](const std::string& parameters, const std::string& words, int code = 2) {
    const Outcome outcome = run_command(MATCHBOX_SLAM_NODE, "__name:=refused " + parameters);
    EXPECT_EQ(outcome.exit_code, code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, words)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  };
  refused("_matcher:=olsen", "there is no matcher 'olsen'");
  ros::param::del("/refused");
  refused("_base_fram:=x", "did you mean 'base_frame'?");
  refused("",
          "events_file; to take it off the parameter server: rosparam delete /refused/base_fram");
  ros::param::del("/refused");
  refused("_scan/min_rage:=x", ": rosparam delete /refused/scan/min_rage");
  ros::param::del("/refused");
  refused("_initial_map:=/nowhere.slam", "cannot read '/nowhere.slam'", 1);
  ros::param::del("/refused");
  refused("_map_frame:=/odom", "odom_frame: 'odom' is not allowed");
  ros::param::del("/refused");
  const TemporaryFolder folder;
  const std::string saved = folder / "map.slam";
  replace_file(saved, "what a disk has left of it");
  refused("_resume:=true _slam/update_map:=false _map_file:=" + (folder / "map"),
          "is no saved map, or is cut off or damaged; resume is true, so it goes on with that map "
          "or not at all: move the file away to begin without it, mv " +
              saved + " " + saved + ".old",
          1);
  EXPECT_EQ(read_file(saved), "what a disk has left of it");
  ros::param::del("/refused");
  // Not damaged, so it is not set aside either.
  const std::string newer = compress("matchbox_slam map, version 99\n");
  replace_file(saved, newer);
  refused("_resume:=true _map_file:=" + (folder / "map"),
          "is a saved map of version 99; this program reads 7, as of 1.0, and 17: use the newer "
          "one that has saved it; resume is true, so it goes on with that map or not at all",
          1);
  EXPECT_EQ(read_file(saved), newer);
}

TEST_F(SlamNodelet, AMapThatCannotBeResumedIsSetAsideForANewOne) {
  const TemporaryFolder folder;
  replace_file(folder / "map.slam", "what a disk has left of it");
  replace_file(folder / "map.pgm", "its image");
  const auto started = [&] {
    return run_command(
        "timeout", std::string("--preserve-status --signal=INT 3 ") + MATCHBOX_SLAM_NODE +
                       " __name:=begins_anew __ns:=/elsewhere scan:=/nowhere _publish_tf:=false "
                       "_resume:=true _map_file:=" +
                       (folder / "map"));
  };
  const Outcome first = started();
  EXPECT_EQ(first.exit_code, 0) << first.output;
  EXPECT_TRUE(contains(first.output,
                       "is no saved map, or is cut off or damaged; a new map begins. "
                       "That one and its images are in " +
                           (folder / "map.damaged") + " now"))
      << first.output;
  EXPECT_TRUE(contains(first.output, "mapping with matchbox_slam/Olson")) << first.output;
  EXPECT_EQ(read_file(folder / "map.damaged/map.slam"), "what a disk has left of it");
  EXPECT_EQ(read_file(folder / "map.damaged/map.pgm"), "its image");
  EXPECT_FALSE(std::filesystem::exists(folder / "map.slam"));

  // And another one, beside it.
  replace_file(folder / "map.slam", "another one");
  EXPECT_EQ(started().exit_code, 0);
  EXPECT_EQ(read_file(folder / "map.damaged/map.slam"), "what a disk has left of it");
  EXPECT_EQ(read_file(folder / "map.damaged.2/map.slam"), "another one");
  ros::param::del("/elsewhere/begins_anew");
}

TEST_F(SlamNodelet, NodesHaveHelp) {
  for (const char* flag : {"--help", "-h"}) {
    const Outcome help = run_command(MATCHBOX_SLAM_NODE, flag);
    EXPECT_EQ(help.exit_code, 0);
    for (const char* words : {"Usage: slam_node", "_NAME:=VALUE", "base_frame", "map_file"}) {
      EXPECT_TRUE(contains(help.output, words)) << words << "\n" << help.output;
    }
  }
}

TEST_F(SlamNodelet, NodesTellTheirVersion) {
  const Outcome version = run_command(MATCHBOX_SLAM_NODE, "--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.output, version_text("slam_node") + "\n");
}

TEST_F(SlamNodelet, AnArgumentThatRosDoesNotTakeEndsItWithALine) {
  for (const char* argument : {"max_lag:=3", "__name:=a/b", "__tcpros_server_port:=x"}) {
    const Outcome outcome = run_command(MATCHBOX_SLAM_NODE, argument);
    EXPECT_EQ(outcome.exit_code, 2) << argument;
    EXPECT_TRUE(contains(outcome.output, "a parameter of the node begins with '_'"))
        << outcome.output;
    EXPECT_EQ(outcome.output.find('\n'), outcome.output.size() - 1) << outcome.output;
  }
}

TEST_F(SlamNodelet, AnOptionThatThereIsNotEndsItWithAWord) {
  for (const std::string option : {"--hlep", "-v", "--matcher=olson"}) {
    const Outcome outcome = run_command(
        "timeout", std::string("10 ") + MATCHBOX_SLAM_NODE + " __name:=refused " + option);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "slam: unknown option '" + option + "'; see --help\n");
  }
  const Outcome word =
      run_command("timeout", std::string("10 ") + MATCHBOX_SLAM_NODE + " __name:=refused my.bag");
  EXPECT_EQ(word.exit_code, 2);
  EXPECT_EQ(word.output,
            "slam: 'my.bag' is no argument; allowed: _NAME:=VALUE and TOPIC:=OTHER_TOPIC, such as "
            "_matcher:=olson; see --help\n");
  // What roslaunch gives, values that begin with a dash, and an empty argument are none.
  const Outcome outcome = run_command(
      "timeout", std::string("--preserve-status --signal=INT 3 ") + MATCHBOX_SLAM_NODE +
                     " '' __name:=taken __ns:=/elsewhere __log:=/tmp/taken.log scan:=/nowhere "
                     "_start_x:=-1.5 _publish_tf:=false");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "mapping with matchbox_slam/Olson")) << outcome.output;
}

TEST_F(SlamNodelet, SaysThatNoScanComesAndWhereThereAreSome) {
  const ros::Publisher scans = ros::NodeHandle().advertise<sensor_msgs::LaserScan>("/elsewhere", 1);
  const LogWatch log("no scan has come from /nowhere yet; scans are published on ");
  Process node({MATCHBOX_SLAM_NODE, "__ns:=/deaf", "scan:=/nowhere", "_publish_tf:=false"});
  EXPECT_TRUE(wait_until([&] { return !log.line().empty(); }));
  EXPECT_TRUE(contains(log.line(), "/elsewhere")) << log.line();
  EXPECT_EQ(node.exit_code_after(SIGINT), 0);
}

TEST_F(SlamNodelet, ANodeletThatCannotStartIsRefused) {
  ros::param::set("/refused_nodelet/matcher", "olsen");
  nodelet::NodeletLoad load;
  load.request.name = "/refused_nodelet";
  load.request.type = "matchbox_slam/SlamNodelet";
  ros::service::call("/slam_manager/load_nodelet", load);
  EXPECT_FALSE(load.response.success);
  EXPECT_TRUE(listener_->wait_until(
      [] {
        return std::any_of(
            listener_->errors.begin(), listener_->errors.end(),
            [](const std::string& text) { return contains(text, "there is no matcher 'olsen'"); });
      },
      5.0))
      << "the log says why";
}

/// Publishes scans of a room and the odometry of a robot at rest, later than anything in the bag.
class LiveRobot {
 public:
  LiveRobot()
      : scans_(node_.advertise<sensor_msgs::LaserScan>("/base_scan", 10)),
        transforms_(node_.advertise<tf2_msgs::TFMessage>("/tf", 10)),
        clock_(node_.advertise<rosgraph_msgs::Clock>("/clock", 10)),
        stamp_(ros::Time::now().toSec() + 5.0) {}

  [[nodiscard]] bool is_heard() const {
    return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0;
  }

  /// One scan and the transforms around it.
  void step() {
    stamp_ += 0.1;
    rosgraph_msgs::Clock clock;
    clock.clock = ros::Time(stamp_ + 0.06);
    clock_.publish(clock);
    for (const double time : {stamp_ - 0.05, stamp_ + 0.05}) {
      transforms_.publish(make_link(time, "odom_combined", "base_footprint", 1.0));
    }
    scans_.publish(make_scan(stamp_, "base_footprint"));
  }

 private:
  ros::NodeHandle node_;
  ros::Publisher scans_;
  ros::Publisher transforms_;
  ros::Publisher clock_;
  double stamp_;
};

/// Changes one text of the node's configuration as rqt_reconfigure does.
/// @param entry_name  of the answer, whose value is returned; empty: the one that is changed.
std::string reconfigure(const std::string& name, const std::string& value,
                        const std::string& entry_name = {}) {
  dynamic_reconfigure::Reconfigure service;
  dynamic_reconfigure::StrParameter parameter;
  parameter.name = name;
  parameter.value = value;
  service.request.config.strs.push_back(parameter);
  EXPECT_TRUE(ros::service::call("/slam/set_parameters", service));
  for (const auto& entry : service.response.config.strs) {
    if (entry.name == (entry_name.empty() ? name : entry_name)) {
      return entry.value;
    }
  }
  return "none";
}

TEST_F(SlamNodelet, TheMatcherMayChangeInMidRun) {
  LiveRobot robot;
  ASSERT_TRUE(listener_->wait_until([&] { return robot.is_heard(); }, 10.0));
  const auto next_match = [&] {
    const std::size_t count = listener_->matches.size();
    for (int k = 0; k < 50 && listener_->matches.size() == count; ++k) {
      robot.step();
      listener_->wait_until([&] { return listener_->matches.size() > count; }, 0.1);
    }
    return listener_->matches.back();
  };
  const std::size_t map_size = listener_->latched_map().data.size();
  EXPECT_EQ(reconfigure("matcher", "olsen"), "olson");
  const std::string refused = reconfigure("matcher", "olsen", "refused");
  EXPECT_TRUE(contains(refused, "there is no matcher 'olsen'")) << refused;
  EXPECT_TRUE(listener_->wait_until(
      [] {
        return std::any_of(listener_->errors.begin(), listener_->errors.end(),
                           [](const std::string& text) {
                             return contains(text, "not changed: there is no matcher 'olsen'");
                           });
      },
      5.0));
  EXPECT_EQ(next_match().matcher, "matchbox_slam/Olson");
  EXPECT_EQ(reconfigure("matcher", "hough"), "hough");
  listener_->wait_until([] { return false; }, 0.3);
  EXPECT_EQ(next_match().matcher, "matchbox_slam/Hough");
  EXPECT_GE(listener_->latched_map().data.size(), map_size) << "the map stays";
  EXPECT_EQ(reconfigure("matcher", "olson"), "olson");
  EXPECT_EQ(ros::param::param<std::string>("/slam/matcher", ""), "olson");
  const auto description = ros::topic::waitForMessage<dynamic_reconfigure::ConfigDescription>(
      "/slam/parameter_descriptions");
  ASSERT_NE(description, nullptr);
  EXPECT_GT(description->groups.front().parameters.size(), 80U);
}

TEST_F(SlamNodelet, ThePathEndsAtTheRobotBetweenMapsToo) {
  LiveRobot robot;
  ASSERT_TRUE(listener_->wait_until([&] { return robot.is_heard(); }, 10.0));
  dynamic_reconfigure::Reconfigure service;
  dynamic_reconfigure::DoubleParameter interval;
  interval.name = "map_update_interval";
  interval.value = 3600.0;
  service.request.config.doubles.push_back(interval);
  ASSERT_TRUE(ros::service::call("/slam/set_parameters", service));
  listener_->wait_until([] { return false; }, 1.5);  // the last map that was due
  const auto is_at_robot = [] {
    return !listener_->path.poses.empty() &&
           listener_->path.poses.back().header.stamp == listener_->poses.back().header.stamp;
  };
  const std::size_t before = listener_->poses.size();
  for (int k = 0; k < 100 && listener_->poses.size() == before; ++k) {
    robot.step();
    listener_->wait_until([&] { return listener_->poses.size() > before; }, 0.1);
  }
  ASSERT_GT(listener_->poses.size(), before);
  EXPECT_TRUE(listener_->wait_until(is_at_robot, 3.0));
  service.request.config.doubles.front().value = 1.0;
  ASSERT_TRUE(ros::service::call("/slam/set_parameters", service));
}

TEST_F(SlamNodelet, PublishesNoTransformWhereThatIsTurnedOff) {
  LiveRobot robot;
  ASSERT_TRUE(listener_->wait_until([&] { return robot.is_heard(); }, 10.0));
  const auto poses_come = [&](std::size_t more) {
    const std::size_t count = listener_->poses.size() + more;
    for (int k = 0; k < 100 && listener_->poses.size() < count; ++k) {
      robot.step();
      listener_->wait_until([] { return false; }, 0.1);
    }
    return listener_->poses.size() >= count;
  };
  ASSERT_TRUE(poses_come(2));
  const auto set_publish_tf = [](bool value) {
    dynamic_reconfigure::Reconfigure service;
    dynamic_reconfigure::BoolParameter parameter;
    parameter.name = "publish_tf";
    parameter.value = static_cast<std::uint8_t>(value);
    service.request.config.bools.push_back(parameter);
    EXPECT_TRUE(ros::service::call("/slam/set_parameters", service));
  };
  set_publish_tf(false);
  listener_->wait_until([] { return false; }, 0.5);  // those on their way
  const std::size_t transforms = listener_->leads.size();
  ASSERT_TRUE(poses_come(5));
  EXPECT_EQ(listener_->leads.size(), transforms);
  set_publish_tf(true);
  ASSERT_TRUE(poses_come(5));
  EXPECT_GT(listener_->leads.size(), transforms);
}

TEST_F(SlamNodelet, GoesOnWithASavedMap) {
  ASSERT_TRUE(call("/slam/save_map").success);
  const std::string saved = read_file(folder_ + "/node_map.slam");
  LoadMap load;
  load.request.path = folder_ + "/nowhere.slam";
  ASSERT_TRUE(ros::service::call("/slam/load_map", load));
  EXPECT_FALSE(load.response.success);
  EXPECT_TRUE(contains(load.response.message, "nowhere.slam")) << load.response.message;
  load.request.path = folder_ + "/node_map.slam";
  ASSERT_TRUE(ros::service::call("/slam/load_map", load));
  EXPECT_TRUE(load.response.success) << load.response.message;
  nav_msgs::GetMap map;
  ASSERT_TRUE(ros::service::call("/dynamic_map", map));
  const MapImage image = read_map(folder_ + "/node_map.yaml");
  EXPECT_EQ(static_cast<int>(map.response.map.info.width), image.width);
  // The recording's own scan is found in it, but the robot's pose stays: no scan has come in since.
  Relocalise service;
  ASSERT_TRUE(ros::service::call("/slam/relocalise", service));
  EXPECT_TRUE(contains(service.response.message, "no scan was used yet since the map was loaded"))
      << service.response.message;
}

TEST_F(SlamNodelet, SearchesInAnImageAsAmongKeyScans) {
  LiveRobot robot;
  ASSERT_TRUE(listener_->wait_until([&] { return robot.is_heard(); }, 10.0));
  LoadMap load;
  load.request.path = folder_ + "/node_map.yaml";
  ASSERT_TRUE(ros::service::call("/slam/load_map", load));
  ASSERT_TRUE(load.response.success) << load.response.message;
  EXPECT_TRUE(contains(load.response.message, "or by ~relocalise")) << load.response.message;
  // One scan tells where the laser is on the robot; here it is the base.
  const std::size_t before = listener_->poses.size();
  for (int k = 0; k < 100 && listener_->poses.size() == before; ++k) {
    robot.step();
    listener_->wait_until([&] { return listener_->poses.size() > before; }, 0.1);
  }
  ASSERT_GT(listener_->poses.size(), before);
  const std::size_t number = truth_.size() / 2;
  Relocalise service;
  service.request.scan = recorded_scan(folder_ + "/run.bag", number);
  ASSERT_TRUE(ros::service::call("/slam/relocalise", service));
  ASSERT_FALSE(service.response.poses.empty()) << service.response.message;
  const Pose2 laser = truth_[number] * Pose2{0.275, 0.0, 0.0};
  const Pose2 best = to_pose2(service.response.poses.front());
  EXPECT_NEAR(best.x, laser.x, 0.1);
  EXPECT_NEAR(best.y, laser.y, 0.1);
  EXPECT_NEAR(wrap_angle(best.theta - laser.theta), 0.0, 0.05);
  load.request.path = folder_ + "/node_map.slam";
  ASSERT_TRUE(ros::service::call("/slam/load_map", load));
  EXPECT_TRUE(contains(load.response.message, "or by ~relocalise")) << load.response.message;
}

TEST_F(SlamNodelet, IsPausedAndToldWhereItIs) {
  LiveRobot robot;
  const auto steps_until = [&](const std::function<bool()>& condition) {
    for (int k = 0; k < 100 && !condition(); ++k) {
      robot.step();
      listener_->wait_until(condition, 0.1);
    }
    return condition();
  };
  ASSERT_TRUE(listener_->wait_until([&] { return robot.is_heard(); }, 10.0));
  const std::size_t before = listener_->poses.size();
  ASSERT_TRUE(steps_until([&] { return listener_->poses.size() > before; }));

  std_srvs::SetBool pause;
  pause.request.data = 1;
  ASSERT_TRUE(ros::service::call("/slam/pause", pause));
  EXPECT_TRUE(pause.response.success);
  listener_->wait_until([] { return false; }, 0.5);  // those on their way
  const std::size_t paused = listener_->poses.size();
  const std::size_t transforms = listener_->leads.size();
  EXPECT_TRUE(steps_until([] { return value_of("Scans skipped: paused") >= "1"; }));
  EXPECT_TRUE(steps_until([&] { return listener_->leads.size() > transforms; })) << "tf goes on";
  EXPECT_EQ(listener_->poses.size(), paused);
  pause.request.data = 0;
  ASSERT_TRUE(ros::service::call("/slam/pause", pause));
  EXPECT_TRUE(steps_until([&] { return listener_->poses.size() > paused; }));

  ros::NodeHandle node;
  ros::Publisher told = node.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 1);
  ASSERT_TRUE(listener_->wait_until([&] { return told.getNumSubscribers() > 0; }, 10.0));
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.pose.pose = to_pose_message(Pose2{500.0, 40.0, 1.0});  // far from all that is in the map
  pose.header.frame_id = "odom_combined";
  told.publish(pose);
  listener_->wait_until([] { return false; }, 0.5);
  std::size_t count = listener_->poses.size();
  ASSERT_TRUE(steps_until([&] { return listener_->poses.size() > count; }));
  EXPECT_LT(std::abs(listener_->poses.back().pose.pose.position.x), 100.0) << "not the map frame";
  pose.header.frame_id = "map";
  told.publish(pose);
  listener_->wait_until([] { return false; }, 0.5);
  count = listener_->poses.size();
  ASSERT_TRUE(steps_until([&] { return listener_->poses.size() > count; }));
  const Pose2 now = to_pose2(listener_->poses.back().pose.pose);
  EXPECT_NEAR(now.x, 500.0, 1.0);
  EXPECT_NEAR(now.y, 40.0, 1.0);
}

TEST_F(SlamNodelet, ResetForgetsTheMap) {  // the last test: nothing is left afterwards
  EXPECT_TRUE(call("/slam/reset").success);
  nav_msgs::GetMap service;
  ASSERT_TRUE(ros::service::call("/dynamic_map", service));
  EXPECT_TRUE(service.response.map.data.empty());
  EXPECT_TRUE(listener_->wait_until(
      [] { return listener_->path.poses.empty() && listener_->odometry_path.poses.empty(); }, 10.0))
      << "the paths are empty too";
  const std_srvs::Trigger::Response saved = call("/slam/save_map");
  EXPECT_FALSE(saved.success) << "an empty map would replace a good one";
  EXPECT_TRUE(contains(saved.message, "nothing is saved")) << saved.message;
}

}  // namespace
}  // namespace matchbox_slam
