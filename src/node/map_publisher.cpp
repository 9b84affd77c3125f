#include "node/map_publisher.hpp"

#include <nav_msgs/MapMetaData.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/console.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "node/graph_markers.hpp"
#include "ros/message_conversion.hpp"

namespace matchbox_slam {
namespace {

std::chrono::steady_clock::duration seconds(double count) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(count));
}

}  // namespace

MapPublisher::MapPublisher(ros::NodeHandle& node, std::string map_frame, double interval,
                           std::function<MapRevision()> revision,
                           std::function<MapSnapshot()> snapshot,
                           std::function<PathSnapshot()> paths)
    : map_frame_(std::move(map_frame)),
      interval_(interval),
      revision_(std::move(revision)),
      snapshot_(std::move(snapshot)),
      paths_(std::move(paths)),
      map_(node.advertise<nav_msgs::OccupancyGrid>("map", 1, true)),
      metadata_(node.advertise<nav_msgs::MapMetaData>("map_metadata", 1, true)),
      path_(node.advertise<nav_msgs::Path>("path", 1, true)),
      odometry_path_(node.advertise<nav_msgs::Path>("odometry_path", 1, true)),
      constraints_(node.advertise<visualization_msgs::MarkerArray>("constraints", 1, true)),
      map_time_(Clock::now()),
      paths_time_(map_time_),
      thread_([this] { run(); }) {}

MapPublisher::~MapPublisher() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  stop_changed_.notify_all();
  thread_.join();
}

void MapPublisher::set_interval(double interval) {
  const std::lock_guard<std::mutex> lock(mutex_);
  interval_ = interval;
}

MapPublisher::Clock::time_point MapPublisher::map_due() const {
  return map_time_ + seconds(interval_);
}

/// Paths of 20,000 poses are 3 MB, which may go through the air.
MapPublisher::Clock::time_point MapPublisher::paths_due() const {
  constexpr double kMinInterval = 0.2;  // [s]
  constexpr double kSecondsPerPose = 50e-6;
  return paths_time_ +
         seconds(std::max(kMinInterval, kSecondsPerPose * static_cast<double>(path_poses_)));
}

void MapPublisher::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (
      !stop_changed_.wait_until(lock, std::min(map_due(), paths_due()), [this] { return stop_; })) {
    const bool map_is_due = Clock::now() >= map_due();
    const bool paths_are_due = Clock::now() >= paths_due();
    lock.unlock();
    try {
      if (paths_are_due) {
        publish_paths();
      }
      if (map_is_due) {
        publish_changes();
      }
    } catch (const std::exception& error) {  // the next map may be published again
      ROS_ERROR_STREAM_THROTTLE(10.0, "publishing the map: " << error.what());
    }
    lock.lock();
    paths_time_ = paths_are_due ? Clock::now() : paths_time_;
    map_time_ = map_is_due ? Clock::now() : map_time_;
  }
}

void MapPublisher::publish_changes() {
  const MapRevision now = revision_();
  const auto has_grown = [&now](const MapRevision& published) {
    return now.resets != published.resets || now.inserted != published.inserted;
  };
  const bool map_changed = has_grown(published_map_);
  const bool constraints_changed =
      has_grown(published_constraints_) && constraints_.getNumSubscribers() > 0;
  if (!map_changed && !constraints_changed) {
    return;
  }
  const MapSnapshot snapshot = snapshot_();
  if (map_changed) {
    publish_map(snapshot);
  }
  if (constraints_changed) {
    constraints_.publish(to_markers(snapshot.graph, map_frame_, snapshot.stamp));
    published_constraints_ = snapshot.revision;
  }
}

void MapPublisher::publish_map(const MapSnapshot& snapshot) {
  const nav_msgs::OccupancyGrid message =
      to_message(snapshot.occupancy, map_frame_, snapshot.stamp);
  map_.publish(message);
  metadata_.publish(message.info);
  published_map_ = snapshot.revision;
}

void MapPublisher::publish_paths() {
  const MapRevision now = revision_();
  const bool has_changed =
      now.resets != published_paths_.resets || now.scans != published_paths_.scans;
  if (!has_changed || path_.getNumSubscribers() + odometry_path_.getNumSubscribers() == 0) {
    return;
  }
  const PathSnapshot snapshot = paths_();
  path_.publish(to_path(snapshot.path, {}, snapshot.stamp));
  Pose2 map_from_odom;
  if (!snapshot.odometry_path.empty() && !snapshot.path.empty()) {
    map_from_odom = snapshot.path.front().pose * snapshot.odometry_path.front().pose.inverse();
  }
  odometry_path_.publish(to_path(snapshot.odometry_path, map_from_odom, snapshot.stamp));
  published_paths_ = snapshot.revision;
  path_poses_ = snapshot.path.size() + snapshot.odometry_path.size();
}

nav_msgs::Path MapPublisher::to_path(const std::vector<StampedPose2>& poses,
                                     const Pose2& map_from_their_frame,
                                     const ros::Time& stamp) const {
  nav_msgs::Path path;
  path.header.frame_id = map_frame_;
  path.header.stamp = stamp;
  path.poses.reserve(poses.size());
  for (const StampedPose2& pose : poses) {
    geometry_msgs::PoseStamped message;
    message.header.frame_id = map_frame_;
    message.header.stamp = ros::Time(pose.stamp);
    message.pose = to_pose_message(map_from_their_frame * pose.pose);
    path.poses.push_back(std::move(message));
  }
  return path;
}

}  // namespace matchbox_slam
