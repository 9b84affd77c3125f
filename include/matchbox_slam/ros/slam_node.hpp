#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/GetMap.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/transform_broadcaster.h>

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "matchbox_slam/Relocalise.h"
#include "matchbox_slam/ros/map_publisher.hpp"
#include "matchbox_slam/ros/scan_queue.hpp"
#include "matchbox_slam/ros/slam_diagnostics.hpp"
#include "matchbox_slam/ros/slam_run.hpp"
#include "matchbox_slam/ros/slam_setup.hpp"

namespace matchbox_slam {

/// The SLAM node: messages in, the same queue and engine as in map_bag, messages out. Callbacks
/// only fill the queue; a thread of its own does the mapping, another publishes maps, a third
/// answers services, so that none waits for another.
class SlamNode {
 public:
  /// Starts at once. Throws ConfigurationError for private parameters that are unknown or not
  /// allowed, and FileError when the trajectory file cannot be written.
  SlamNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node);

  /// Maps what is ready, then writes the trajectory file.
  ~SlamNode();

  SlamNode(const SlamNode&) = delete;
  SlamNode& operator=(const SlamNode&) = delete;

 private:
  void on_scan(const ros::MessageEvent<const sensor_msgs::LaserScan>& event);
  void on_transforms(const ros::MessageEvent<const tf2_msgs::TFMessage>& event, bool is_static);
  void on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void warn_of_map_link(const ros::MessageEvent<const tf2_msgs::TFMessage>& event);
  void warn_of_skipped();

  void run_mapping();
  void handle(const ScanQueue::Item& item);
  void map_scan(const ReadyScan& scan);
  void jump(const TimeJump& jump);
  void publish_pose(const ReadyScan& scan, const ScanOutcome& outcome);
  [[nodiscard]] geometry_msgs::TransformStamped map_transform(const ReadyScan& scan,
                                                              const ScanOutcome& outcome) const;
  void publish_transform();

  bool answer_dynamic_map(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool answer_save_map(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool answer_reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool answer_pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool answer_relocalise(Relocalise::Request& request, Relocalise::Response& response);
  void start_services();
  void update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status);

  void forget_map();
  [[nodiscard]] MapRevision map_revision();
  [[nodiscard]] MapSnapshot map_snapshot();
  void save_map_files(const MapSnapshot& snapshot) const;
  void save_trajectory(const MapSnapshot& snapshot) const;

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  MatcherLoader loader_;
  SlamSetup setup_;
  ros::CallbackQueue service_queue_;  ///< before all that puts callbacks in it

  std::mutex queue_mutex_;  ///< guards what follows, up to the next mutex
  std::condition_variable queue_changed_;
  ScanQueue queue_;
  std::map<SkipReason, ros::WallTime> last_warning_;
  std::string last_skip_;
  bool told_of_map_link_ = false;
  bool stop_ = false;

  std::mutex run_mutex_;  ///< likewise
  SlamRun run_;
  ros::Time last_stamp_;
  std::optional<Eigen::Isometry3d> base_from_laser_;  ///< at the newest scan
  std::size_t resets_ = 0;

  std::mutex transform_mutex_;  ///< likewise; locked last
  std::optional<geometry_msgs::TransformStamped> map_transform_;

  ros::Time last_transform_time_;  ///< used by the timer alone
  SlamDiagnostics diagnostics_;
  diagnostic_updater::Updater diagnostic_updater_;
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Publisher pose_publisher_;
  ros::Timer transform_timer_;
  ros::WallTimer diagnostic_timer_;
  ros::Subscriber scan_subscriber_;
  ros::Subscriber transform_subscriber_;
  ros::Subscriber static_transform_subscriber_;
  ros::Subscriber initial_pose_subscriber_;
  ros::ServiceServer dynamic_map_service_;
  ros::ServiceServer save_map_service_;
  ros::ServiceServer reset_service_;
  ros::ServiceServer pause_service_;
  ros::ServiceServer relocalise_service_;
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
  std::unique_ptr<MapPublisher> map_publisher_;
  std::thread mapping_thread_;
};

}  // namespace matchbox_slam
