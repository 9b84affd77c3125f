// Of node/slam_node.hpp: everybody wants something of the node at once. This is what the thread
// sanitizer looks at; CONTRIBUTING.md says how.

#include <dynamic_reconfigure/Reconfigure.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/GetMap.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/Relocalise.h"
#include "node/node_process.hpp"
#include "node/slam_node.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

dynamic_reconfigure::Reconfigure choice_of(const std::string& matcher, double tolerance) {
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
    call_again_and_again("/" + node + "/set_parameters", choice_of("hough", 0.0));
    call_again_and_again("/" + node + "/set_parameters", choice_of("olson", 0.1));
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

TEST(SlamCrowd, ServesACrowdAndMapsOn) {
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
