#pragma once

#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "geometry/trajectory.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"
#include "run/map_saver.hpp"

namespace matchbox_slam {

/// The state of the mapping at one moment. Copies share the grid's memory.
struct MapSnapshot {
  MapRevision revision;
  ros::Time stamp;  ///< of the newest scan
  OccupancyGrid occupancy{0.05};
  PoseGraph graph;  ///< of the map's key scans
};

/// The robot's way up to one moment.
struct PathSnapshot {
  MapRevision revision;
  ros::Time stamp;                          ///< of the newest scan
  std::vector<StampedPose2> path;           ///< of the base in the map, up to that scan
  std::vector<StampedPose2> odometry_path;  ///< of the base in the odometry frame, likewise
};

/// Publishes map, map_metadata, path, odometry_path and constraints, all latched, from a thread of
/// its own, so that the mapping never waits for it; each only when it has changed. The odometry is
/// drawn in the map frame, its first pose where the trajectory's is. The paths come five times a
/// second, so that they end at the robot, and less often where they are long.
class MapPublisher {
 public:
  /// @param revision, snapshot, paths  called from the thread.
  /// @param interval  shortest time between two maps [s], by the wall clock.
  MapPublisher(ros::NodeHandle& node, std::string map_frame, double interval,
               std::function<MapRevision()> revision, std::function<MapSnapshot()> snapshot,
               std::function<PathSnapshot()> paths);
  ~MapPublisher();

  /// Another shortest time between two maps [s].
  void set_interval(double interval);

  MapPublisher(const MapPublisher&) = delete;
  MapPublisher& operator=(const MapPublisher&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  [[nodiscard]] Clock::time_point map_due() const;
  [[nodiscard]] Clock::time_point paths_due() const;
  void publish_changes();
  void publish_map(const MapSnapshot& snapshot);
  void publish_paths();
  [[nodiscard]] nav_msgs::Path to_path(const std::vector<StampedPose2>& poses,
                                       const Pose2& map_from_their_frame,
                                       const ros::Time& stamp) const;

  std::string map_frame_;
  double interval_;
  std::function<MapRevision()> revision_;
  std::function<MapSnapshot()> snapshot_;
  std::function<PathSnapshot()> paths_;
  ros::Publisher map_;
  ros::Publisher metadata_;
  ros::Publisher path_;
  ros::Publisher odometry_path_;
  ros::Publisher constraints_;
  MapRevision published_map_;
  MapRevision published_paths_;
  MapRevision published_constraints_;
  std::mutex mutex_;
  std::condition_variable stop_changed_;
  bool stop_ = false;
  Clock::time_point map_time_;    ///< when it was due last
  Clock::time_point paths_time_;  ///< likewise
  std::size_t path_poses_ = 0;    ///< that were published last
  std::thread thread_;            ///< last: it uses all of the above
};

}  // namespace matchbox_slam
