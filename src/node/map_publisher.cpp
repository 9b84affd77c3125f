#include "node/map_publisher.hpp"

#include <nav_msgs/MapMetaData.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/console.h>

#include <chrono>
#include <exception>
#include <utility>

#include "node/graph_markers.hpp"
#include "ros/message_conversion.hpp"

namespace matchbox_slam {

MapPublisher::MapPublisher(ros::NodeHandle& node, std::string map_frame, double interval,
                           std::function<MapRevision()> revision,
                           std::function<MapSnapshot()> snapshot)
    : map_frame_(std::move(map_frame)),
      interval_(interval),
      revision_(std::move(revision)),
      snapshot_(std::move(snapshot)),
      map_(node.advertise<nav_msgs::OccupancyGrid>("map", 1, true)),
      metadata_(node.advertise<nav_msgs::MapMetaData>("map_metadata", 1, true)),
      path_(node.advertise<nav_msgs::Path>("path", 1, true)),
      odometry_path_(node.advertise<nav_msgs::Path>("odometry_path", 1, true)),
      constraints_(node.advertise<visualization_msgs::MarkerArray>("constraints", 1, true)),
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

void MapPublisher::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop_changed_.wait_for(lock, std::chrono::duration<double>(interval_),
                                 [this] { return stop_; })) {
    lock.unlock();
    try {
      publish_changes();
    } catch (const std::exception& error) {  // the next map may be published again
      ROS_ERROR_STREAM_THROTTLE(10.0, "publishing the map: " << error.what());
    }
    lock.lock();
  }
}

void MapPublisher::publish_changes() {
  const MapRevision now = revision_();
  const auto has_grown = [&now](const MapRevision& published) {
    return now.resets != published.resets || now.inserted != published.inserted;
  };
  const bool map_changed = has_grown(published_map_);
  const bool paths_changed =
      (now.resets != published_paths_.resets || now.scans != published_paths_.scans) &&
      path_.getNumSubscribers() + odometry_path_.getNumSubscribers() > 0;
  const bool constraints_changed =
      has_grown(published_constraints_) && constraints_.getNumSubscribers() > 0;
  if (!map_changed && !paths_changed && !constraints_changed) {
    return;
  }
  const MapSnapshot snapshot = snapshot_();
  if (map_changed) {
    publish_map(snapshot);
  }
  if (paths_changed) {
    publish_paths(snapshot);
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

void MapPublisher::publish_paths(const MapSnapshot& snapshot) {
  path_.publish(to_path(snapshot.path, {}, snapshot.stamp));
  Pose2 map_from_odom;
  if (!snapshot.odometry_path.empty() && !snapshot.path.empty()) {
    map_from_odom = snapshot.path.front().pose * snapshot.odometry_path.front().pose.inverse();
  }
  odometry_path_.publish(to_path(snapshot.odometry_path, map_from_odom, snapshot.stamp));
  published_paths_ = snapshot.revision;
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
