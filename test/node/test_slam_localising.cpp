// Of node/slam_node.hpp: the node in a map that stays as it is, as people use amcl.

#include <geometry_msgs/PoseArray.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Empty.h>
#include <tf2_msgs/TFMessage.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/LikelyPoses.h"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/slam_listener.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

/// A node in the map of a drive, and that drive again.
class Localising : public testing::Test {
 protected:
  void SetUp() override {
    SimulationOptions options;
    options.time.duration = 40.0;
    options.laser.beams = 360;
    options.laser.scan_rate = 10.0;
    const World world = make_world("rooms", 4);
    run_ = simulate_run(world, world.route(), options, 4);
    SimulatedBagWriter(folder_ / "run.bag", {}).write(run_, {"rooms", 4, options.laser, {}});
    const Outcome mapped = run_command(
        MATCHBOX_MAP_BAG, (folder_ / "run.bag") + " --quiet --out " + (folder_ / "map"));
    ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
    map_from_world_ = run_.world_from_base.front().inverse();
    ros::param::del("/localising");
    ros::param::set("/localising/base_frame", "base_footprint");
    ros::param::set("/localising/odom_frame", "odom_combined");
    ros::param::set("/localising/initial_map", folder_ / "map/map.slam");
    ros::param::set("/localising/slam/update_map", false);
    bag_.open(folder_ / "run.bag", rosbag::bagmode::Read);
  }

  void start() {
    slam_ = std::make_unique<SlamNode>(ros::NodeHandle(), ros::NodeHandle("/localising"));
    ASSERT_TRUE(listener_.wait_until(
        [&] {
          return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0 &&
                 likely_subscriber_.getNumPublishers() > 0 &&
                 particles_subscriber_.getNumPublishers() > 0;
        },
        30.0));
  }

  /// Plays scans of the drive, by a clock that is moved so far, until it is so or the last one has
  /// come. Returns the number of the scan that comes next.
  template <typename Condition>
  std::size_t play(std::size_t from, std::size_t to, double moved, const Condition& is_so) {
    rosbag::View view(bag_);
    std::size_t next = 0;
    const ros::Duration step(moved);
    for (const rosbag::MessageInstance& message : view) {
      if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
        tf2_msgs::TFMessage now = *transforms;
        for (auto& transform : now.transforms) {
          transform.header.stamp += step;
        }
        const bool is_near =
            transforms->transforms.front().header.stamp.toSec() > run_.scans[from].stamp - 0.5;
        if (is_near || next == 0) {  // what never moves comes first
          transforms_.publish(now);
        }
      } else if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) {
        if (next++ < from) {
          continue;
        }
        sensor_msgs::LaserScan now = *scan;
        now.header.stamp += step;
        scans_.publish(now);
        ++published_;
        if (next >= to || !wait_for_all_but(6) || is_so()) {
          break;
        }
      }
    }
    return next;
  }

  /// The newest ones wait for their transforms, which come after them.
  bool wait_for_all_but(std::size_t newest) {
    return listener_.wait_until([&] { return listener_.matches.size() + newest >= published_; },
                                20.0);
  }

  [[nodiscard]] std::string state() const {
    return listener_.matches.empty() ? "" : listener_.matches.back().state;
  }

  /// How far the newest pose is from the truth [m].
  [[nodiscard]] double error(double moved) const {
    const auto& pose = listener_.poses.back();
    const double stamp = pose.header.stamp.toSec() - moved;
    for (std::size_t i = 0; i < run_.scans.size(); ++i) {
      if (std::abs(run_.scans[i].stamp - stamp) < 1e-3) {
        const Pose2 truth = map_from_world_ * run_.world_from_base[i];
        return (to_pose2(pose.pose.pose).translation() - truth.translation()).norm();
      }
    }
    return 1e9;
  }

  void on_likely(const LikelyPoses& message) { likely_.push_back(message); }
  void on_particles(const geometry_msgs::PoseArray& message) { particles_.push_back(message); }

  TemporaryFolder folder_;
  SimulatedRun run_;
  Pose2 map_from_world_;
  rosbag::Bag bag_;
  ros::NodeHandle node_;
  ros::Publisher scans_ = node_.advertise<sensor_msgs::LaserScan>("/scan", 1000);
  ros::Publisher transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  SlamListener listener_;
  std::vector<LikelyPoses> likely_;
  std::vector<geometry_msgs::PoseArray> particles_;
  ros::Subscriber likely_subscriber_ =
      node_.subscribe("likely_poses", 10000, &Localising::on_likely, this);
  ros::Subscriber particles_subscriber_ =
      node_.subscribe("particlecloud", 10000, &Localising::on_particles, this);
  std::size_t published_ = 0;
  std::unique_ptr<SlamNode> slam_;
};

TEST_F(Localising, FindsItselfWithoutAWordAndSaysWhatItDoesNotKnow) {
  start();
  const std::size_t begin = run_.scans.size() / 3;
  std::size_t next = play(begin, run_.scans.size(), 0.0, [&] { return state() == "tracking"; });
  ASSERT_EQ(state(), "tracking");
  RecordProperty("scans_until_found", std::to_string(next - begin));
  ASSERT_EQ(listener_.matches.front().state, "lost");
  EXPECT_GT(listener_.poses.front().pose.covariance[0], 25.0) << "it may be anywhere";
  EXPECT_GT(listener_.poses.front().pose.covariance[35], 9.0);
  ASSERT_TRUE(listener_.wait_until([&] { return likely_.size() == particles_.size(); }, 10.0))
      << likely_.size() << " and " << particles_.size() << ", that come one after the other";
  EXPECT_GT(likely_.front().elsewhere, 0.5);
  bool competed = false;
  for (std::size_t i = 0; i + 1 < likely_.size(); ++i) {
    double sum = likely_[i].elsewhere;
    for (const double weight : likely_[i].weights) {
      sum += weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-9);
    EXPECT_EQ(particles_[i].poses.size(), likely_[i].poses.size());
    EXPECT_EQ(particles_[i].header.frame_id, "map");
    competed = competed || !likely_[i].poses.empty();
  }
  EXPECT_TRUE(competed) << "no place was told before it was sure";
  next = play(next, next + 30, 0.0, [] { return false; });
  EXPECT_EQ(state(), "tracking");
  EXPECT_LT(error(0.0), 0.03);
  EXPECT_LT(listener_.poses.back().pose.covariance[0], 0.01);
  EXPECT_EQ(likely_.back().poses.size(), 1U);

  // The clock is set back, and the robot is where it was.
  const std::size_t poses = listener_.poses.size();
  next = play(next, next + 30, -3600.0, [] { return false; });
  ASSERT_GT(listener_.poses.size(), poses + 20);
  for (std::size_t i = listener_.matches.size() - 20; i < listener_.matches.size(); ++i) {
    EXPECT_EQ(listener_.matches[i].state, "tracking");
  }
  EXPECT_LT(error(-3600.0), 0.03);

  // Somebody says that it may be anywhere: navigation keeps what was sure until it is found.
  std_srvs::Empty anywhere;
  const std::size_t repeated = listener_.leads.size();  // until all is told that can be
  ASSERT_TRUE(listener_.wait_until([&] { return listener_.leads.size() > repeated + 3; }, 10.0));
  const Pose2 sure = listener_.map_from_odom;
  {
    ros::AsyncSpinner spinner(1);  // its answer comes from this process
    ASSERT_TRUE(ros::service::call("global_localization", anywhere));
  }
  next = play(next, next + 12, -3600.0, [&] { return state() == "lost"; });
  ASSERT_EQ(state(), "lost");
  EXPECT_GT(listener_.poses.back().pose.covariance[0], 25.0);
  const std::size_t leads = listener_.leads.size();
  ASSERT_TRUE(listener_.wait_until([&] { return listener_.leads.size() > leads + 3; }, 10.0))
      << "the transform is not repeated";
  EXPECT_LT((listener_.map_from_odom.translation() - sure.translation()).norm(), 0.02);
}

TEST_F(Localising, HoldsNoTransformThatNeverWasSure) {
  start();
  play(run_.scans.size() / 3, run_.scans.size() / 3 + 8, 0.0, [] { return false; });
  ASSERT_TRUE(listener_.wait_until([&] { return listener_.poses.size() > 2; }, 10.0));
  ASSERT_EQ(state(), "lost");
  EXPECT_TRUE(listener_.leads.empty());
}

TEST_F(Localising, GivesTheBestTransformWhereThatIsAskedFor) {
  ros::param::set("/localising/tf_while_lost", "best");
  start();
  play(run_.scans.size() / 3, run_.scans.size() / 3 + 8, 0.0, [] { return false; });
  ASSERT_EQ(state(), "lost");
  EXPECT_TRUE(listener_.wait_until([&] { return !listener_.leads.empty(); }, 10.0));
}

TEST_F(Localising, BeginsWhereItIsTold) {
  ros::param::set("/localising/start_x", 0.0);
  start();
  play(0, 20, 0.0, [] { return false; });
  ASSERT_GT(listener_.poses.size(), 10U);
  EXPECT_EQ(listener_.matches.front().state, "tracking");
  EXPECT_LT(listener_.poses.front().pose.covariance[0], 0.1);
}

}  // namespace
}  // namespace matchbox_slam
