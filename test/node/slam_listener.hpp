#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "matchbox_slam/MatchInfo.h"
#include "ros/transform_store.hpp"

namespace matchbox_slam {

/// Remembers what the SLAM node publishes.
class SlamListener {
 public:
  SlamListener() {
    subscribers_.push_back(node_.subscribe("pose", 10000, &SlamListener::on_pose, this));
    subscribers_.push_back(node_.subscribe("match_info", 10000, &SlamListener::on_match, this));
    subscribers_.push_back(node_.subscribe("/tf", 10000, &SlamListener::on_transforms, this));
    subscribers_.push_back(node_.subscribe("path", 10, &SlamListener::on_path, this));
    subscribers_.push_back(node_.subscribe("odometry_path", 10, &SlamListener::on_odometry, this));
    subscribers_.push_back(
        node_.subscribe("/diagnostics", 100, &SlamListener::on_diagnostics, this));
    subscribers_.push_back(node_.subscribe("/rosout", 1000, &SlamListener::on_log, this));
  }

  /// Handles messages until the condition holds; false when that takes longer than `seconds`.
  bool wait_until(const std::function<bool()>& condition, double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end || !ros::ok()) {
        return false;
      }
      ros::spinOnce();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

  /// Waits for the map as one does who comes late: only what is latched arrives.
  nav_msgs::OccupancyGrid latched_map() {
    const auto map = ros::topic::waitForMessage<nav_msgs::OccupancyGrid>("map", node_);
    return map == nullptr ? nav_msgs::OccupancyGrid() : *map;
  }

  /// A value of the diagnostics; empty when there is none of that name.
  [[nodiscard]] std::string value_of(const std::string& name) const {
    for (const auto& value : status.values) {
      if (value.key == name) {
        return value.value;
      }
    }
    return "";
  }

  std::vector<geometry_msgs::PoseWithCovarianceStamped> poses;
  std::vector<MatchInfo> matches;
  TransformStore transforms{""};
  std::vector<ros::Duration> leads;  ///< of map -> odom, stamp against time of arrival
  Pose2 map_from_odom;
  nav_msgs::Path path;
  nav_msgs::Path odometry_path;
  diagnostic_msgs::DiagnosticStatus status;
  std::vector<std::string> errors;  ///< in the log, of any node

 private:
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& pose) { poses.push_back(pose); }
  void on_match(const MatchInfo& match) { matches.push_back(match); }
  void on_path(const nav_msgs::Path& message) { path = message; }
  void on_odometry(const nav_msgs::Path& message) { odometry_path = message; }
  void on_transforms(const tf2_msgs::TFMessage& message) {
    transforms.add(message, false);
    if (!find_map_link(message, "map").empty()) {
      leads.push_back(message.transforms.front().header.stamp - ros::Time::now());
      map_from_odom = project_to_plane(tf2::transformToEigen(message.transforms.front()));
    }
  }
  void on_log(const rosgraph_msgs::Log& log) {
    if (log.level >= rosgraph_msgs::Log::ERROR) {
      errors.push_back(log.msg);
    }
  }
  void on_diagnostics(const diagnostic_msgs::DiagnosticArray& array) {
    for (const auto& candidate : array.status) {
      if (candidate.name.find("SLAM") != std::string::npos) {
        status = candidate;
      }
    }
  }

  ros::NodeHandle node_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace matchbox_slam
