// Of node/slam_node.hpp: nodelets that share a manager. A filter hands its scans to the SLAM
// nodelet without a copy, and two SLAM nodelets do not touch each other.

#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <nodelet/nodelet.h>
#include <ros/serialization.h>
#include <ros/topic_manager.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_srvs/Trigger.h>
#include <topic_tools/shape_shifter.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <pluginlib/class_loader.hpp>
#include <string>
#include <thread>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "node/slam_listener.hpp"
#include "ros/messages.hpp"
#include "simulation/make_world.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

// --- without a copy ---

/// A laser filter that changes nothing. It publishes as ros::Publisher::publish does with a shared
/// pointer, but keeps count of how often ROS asks for the bytes of a message.
class CountingFilter : public nodelet::Nodelet {
 public:
  void publish(const sensor_msgs::LaserScanConstPtr& scan) {
    ros::SerializedMessage message;
    message.type_info = &typeid(sensor_msgs::LaserScan);
    message.message = boost::const_pointer_cast<sensor_msgs::LaserScan>(scan);
    const auto to_bytes = [this, scan] {
      ++serialized_;
      return ros::serialization::serializeMessage(*scan);
    };
    ros::TopicManager::instance()->publish(publisher_.getTopic(), to_bytes, message);
  }

  [[nodiscard]] bool is_heard() const { return publisher_.getNumSubscribers() > 0; }
  [[nodiscard]] std::size_t serialized() const { return serialized_; }

 private:
  void onInit() override {
    publisher_ = getNodeHandle().advertise<sensor_msgs::LaserScan>("scan", 100);
  }

  ros::Publisher publisher_;
  std::atomic<std::size_t> serialized_{0};
};

/// A nodelet manager in this process, with the filter and a SLAM nodelet. What the manager of the
/// `nodelet` package loads by services is loaded by calls here.
class ManagerWithFilter {
 public:
  ManagerWithFilter()
      : loader_([this](const std::string& type) { return create(type); }),
        poses_(node_.subscribe("/filtered/pose", 1000, &ManagerWithFilter::on_pose, this)) {
    ros::param::set("/filtered/slam/use_odometry", false);
    ros::param::set("/filtered/slam/map_frame", "filtered_map");
    const nodelet::V_string none;
    EXPECT_TRUE(loader_.load("/filtered/filter", "CountingFilter", {}, none));
    EXPECT_TRUE(loader_.load("/filtered/slam", "matchbox_slam/SlamNodelet", {}, none));
  }

  [[nodiscard]] CountingFilter& filter() { return *filter_; }

  [[nodiscard]] std::size_t poses() const { return pose_count_; }

 private:
  boost::shared_ptr<nodelet::Nodelet> create(const std::string& type) {
    if (type == "CountingFilter") {
      const auto filter = boost::make_shared<CountingFilter>();
      filter_ = filter.get();
      return filter;
    }
    return plugins_.createInstance(type);
  }
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& /*message*/) { ++pose_count_; }

  ros::NodeHandle node_;
  pluginlib::ClassLoader<nodelet::Nodelet> plugins_{"nodelet", "nodelet::Nodelet"};
  CountingFilter* filter_ = nullptr;  ///< the loader's, which has the queue that it calls back on
  nodelet::Loader loader_;
  std::atomic<std::size_t> pose_count_{0};
  ros::Subscriber poses_;
};

bool wait_for(const std::function<bool()>& condition, double seconds = 20.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!condition() && std::chrono::steady_clock::now() < end) {
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

sensor_msgs::LaserScanConstPtr make_shared_scan(double stamp) {
  return boost::make_shared<sensor_msgs::LaserScan>(make_scan(stamp, "base_link"));
}

TEST(SharedManager, HandsScansOverWithoutACopy) {
  ManagerWithFilter manager;
  ASSERT_TRUE(wait_for([&] { return manager.filter().is_heard(); }));
  // Who listens as the SLAM nodelet does gets the very object that was published.
  std::vector<const sensor_msgs::LaserScan*> seen;
  const boost::function<void(const sensor_msgs::LaserScanConstPtr&)> look =
      [&seen](const sensor_msgs::LaserScanConstPtr& scan) { seen.push_back(scan.get()); };
  ros::NodeHandle node;
  const ros::Subscriber witness =
      node.subscribe<sensor_msgs::LaserScan>("/filtered/scan", 100, look);
  std::vector<sensor_msgs::LaserScanConstPtr> published;
  for (int k = 0; k < 20; ++k) {
    published.push_back(make_shared_scan(100.0 + 0.1 * k));
    manager.filter().publish(published.back());
  }
  ASSERT_TRUE(wait_for([&] { return manager.poses() == 20 && seen.size() == 20; }))
      << manager.poses() << " poses, " << seen.size() << " scans seen";
  for (std::size_t k = 0; k < 20; ++k) {
    EXPECT_EQ(seen[k], published[k].get());
  }
  EXPECT_EQ(manager.filter().serialized(), 0U)
      << "the SLAM nodelet has used all scans, and none was ever made into bytes";

  // One who asks for another type makes ROS serialize: the count is able to tell.
  const boost::function<void(const topic_tools::ShapeShifter::ConstPtr&)> ignore =
      [](const topic_tools::ShapeShifter::ConstPtr& /*message*/) {};
  const ros::Subscriber other =
      node.subscribe<topic_tools::ShapeShifter>("/filtered/scan", 100, ignore);
  manager.filter().publish(make_shared_scan(103.0));
  EXPECT_TRUE(wait_for([&] { return manager.poses() == 21; }));
  EXPECT_EQ(manager.filter().serialized(), 1U);
}

// --- two at once ---

/// The recording with `prefix` in front of its frames and scan topic.
void rename_bag(const std::string& from, const std::string& to, const std::string& prefix) {
  const rosbag::Bag in(from, rosbag::bagmode::Read);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) {
      scan->header.frame_id = prefix + "_" + scan->header.frame_id;
      out.write("/" + prefix + "/base_scan", message.getTime(), *scan);
    } else if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
      for (geometry_msgs::TransformStamped& transform : transforms->transforms) {
        transform.header.frame_id = prefix + "_" + transform.header.frame_id;
        transform.child_frame_id = prefix + "_" + transform.child_frame_id;
      }
      out.write("/tf", message.getTime(), *transforms);
    }
  }
  out.close();
}

/// What map_bag makes of a bag of this name; returns the number of poses.
std::size_t map_offline(const std::string& folder, const std::string& name,
                        const std::string& matcher) {
  const Outcome mapped =
      run_command(MATCHBOX_MAP_BAG, folder + "/" + name + ".bag --quiet --out " + folder + "/" +
                                        name + "_map_bag --config " + MATCHBOX_SOURCE_DIR +
                                        "/config/" + matcher + ".yaml");
  EXPECT_EQ(mapped.exit_code, 0) << mapped.output;
  return read_tum(folder + "/" + name + "_map_bag/trajectory.tum").size();
}

void simulate_bag(const std::string& folder, const std::string& name, const std::string& world_name,
                  std::uint64_t seed) {
  SimulationOptions options;
  options.time.duration = 15.0;
  const World world = make_world(world_name, seed);
  const SimulatedRun run = simulate_run(world, world.route(), options, seed);
  SimulatedBagWriter(folder + "/plain.bag", {})
      .write(run, {world_name, seed, options.laser, run.faults});
  rename_bag(folder + "/plain.bag", folder + "/" + name + ".bag", name);
}

TEST(SharedManager, TwoSlamNodeletsDoNotTouchEachOther) {
  const auto folder = ros::param::param<std::string>("~folder", "");
  ASSERT_NE(folder, "");
  require_writable_folder(folder);
  simulate_bag(folder, "one", "rooms", 4);
  simulate_bag(folder, "two", "random", 5);
  const std::size_t expected_one = map_offline(folder, "one", "olson");
  const std::size_t expected_two = map_offline(folder, "two", "monte_carlo");

  std::atomic<std::size_t> one{0};
  std::atomic<std::size_t> two{0};
  ros::NodeHandle node;
  const auto count_on = [&](const std::string& topic, std::atomic<std::size_t>& count) {
    return node.subscribe<geometry_msgs::PoseWithCovarianceStamped>(
        topic, 10000,
        [&count](const geometry_msgs::PoseWithCovarianceStamped::ConstPtr& /*message*/) {
          ++count;
        });
  };
  const ros::Subscriber poses_one = count_on("/one/pose", one);
  const ros::Subscriber poses_two = count_on("/two/pose", two);
  auto played = std::async(std::launch::async, [&] {
    return run_command(
        "rosbag", "play --quiet --clock --queue=100000 --delay=1 --wait-for-subscribers --rate=2 " +
                      folder + "/one.bag " + folder + "/two.bag");
  });
  EXPECT_TRUE(wait_for([&] { return one == expected_one && two == expected_two; }, 120.0))
      << one << " of " << expected_one << " and " << two << " of " << expected_two << " scans";
  EXPECT_EQ(played.get().exit_code, 0);

  for (const std::string name : {"one", "two"}) {
    std_srvs::Trigger save;
    ASSERT_TRUE(ros::service::call("/" + name + "/slam/save_map", save));
    ASSERT_TRUE(save.response.success) << save.response.message;
    // Not EXPECT_EQ, which would print both files.
    EXPECT_TRUE(read_file(folder + "/" + name + ".tum") ==
                read_file(folder + "/" + name + "_map_bag/trajectory.tum"))
        << name;
    EXPECT_TRUE(read_file(folder + "/" + name + "_map.pgm") ==
                read_file(folder + "/" + name + "_map_bag/map.pgm"))
        << name;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace matchbox_slam
