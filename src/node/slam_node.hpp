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

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/Relocalise.h"
#include "node/map_publisher.hpp"
#include "node/reconfigure_server.hpp"
#include "node/skip_warnings.hpp"
#include "node/slam_diagnostics.hpp"
#include "ros/clock_watch.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/scan_queue.hpp"
#include "run/live_configuration.hpp"
#include "run/slam_run.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// The SLAM node: messages in, the same queue and engine as in map_bag, messages out. Callbacks
/// only fill the queue; a thread of its own does the mapping, another publishes maps, a third
/// answers services, so that none waits for another.
class SlamNode {
 public:
  /// Starts at once. Throws ConfigurationError for private parameters that are unknown or not
  /// allowed, and FileError when the trajectory file cannot be written or the initial map not read.
  SlamNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node);

  /// Maps what is ready, then writes the trajectory file.
  ~SlamNode();

  SlamNode(const SlamNode&) = delete;
  SlamNode& operator=(const SlamNode&) = delete;

 private:
  using ScanEvent = ros::MessageEvent<const sensor_msgs::LaserScan>;

  void subscribe();
  void on_scan(const ScanEvent& event, int laser);
  void on_transforms(const ros::MessageEvent<const tf2_msgs::TFMessage>& event, bool is_static);
  void on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void settle_clocks(const ros::Time& now);
  void warn_of_silence();
  void warn_of_map_link(const ros::MessageEvent<const tf2_msgs::TFMessage>& event);

  void run_mapping();
  void handle(const ScanQueue::Item& item);
  void map_scan(const ReadyScan& scan);
  void jump(const TimeJump& jump);
  void remember_health(const ReadyScan& scan, const ScanOutcome& outcome);
  void publish_pose(const ReadyScan& scan, const ScanOutcome& outcome);
  void publish_match_info(const ReadyScan& scan, const ScanOutcome& outcome, double match_seconds);
  [[nodiscard]] geometry_msgs::TransformStamped map_transform(const ReadyScan& scan,
                                                              const ScanOutcome& outcome) const;
  void publish_transform();

  bool answer_dynamic_map(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool answer_save_map(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool answer_load_map(LoadMap::Request& request, LoadMap::Response& response);
  bool answer_reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool answer_pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool answer_relocalise(Relocalise::Request& request, Relocalise::Response& response);
  void correct_pose(const Pose2& map_from_base_then, const Pose2& believed_then);
  std::vector<OptionDescription> reconfigure(const Parameters& changes);
  void start_services();
  void update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status);

  [[nodiscard]] MapStart read_initial_map(const std::string& path) const;
  void start_from(std::optional<MapStart> map);
  [[nodiscard]] MapRevision map_revision();
  [[nodiscard]] MapSnapshot map_snapshot();
  [[nodiscard]] MapStart map_to_go_on_with();
  void save_map_files(const MapStart& map, const MapSnapshot& snapshot,
                      const std::string& path) const;
  void save_trajectory();

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  MatcherLoader loader_;
  LiveConfiguration configuration_;  ///< changed by the service queue alone
  const RunOptions options_;         ///< what of it does not change
  const std::string trajectory_file_;
  std::optional<MapStart> initial_map_;  ///< not changed after the start
  ros::CallbackQueue service_queue_;     ///< before all that puts callbacks in it

  std::mutex queue_mutex_;  ///< guards what follows, up to the next mutex
  std::condition_variable queue_changed_;
  ScanQueue queue_;
  ClockWatch clock_watch_;
  bool holds_scans_;  ///< until the offset of their clock is known
  std::deque<std::pair<ScanEvent, int>> held_scans_;
  double untold_clock_offset_ = 0.0;  ///< [s] that scans should be moved by and are not
  SkipWarnings skip_warnings_;
  std::set<int> heard_lasers_;
  bool told_of_map_link_ = false;
  bool stop_ = false;

  std::mutex run_mutex_;  ///< likewise
  SlamRun run_;
  std::string matcher_name_;
  std::optional<ReadyScan> newest_scan_;
  Pose2 newest_pose_;  ///< of the base in the map, at that scan
  std::deque<ScanHealth> recent_;
  std::size_t resets_ = 0;

  std::mutex transform_mutex_;  ///< likewise; locked last
  std::optional<geometry_msgs::TransformStamped> map_transform_;

  std::atomic<bool> publish_tf_;
  std::atomic<double> transform_tolerance_;  ///< [s]
  ros::Time last_transform_time_;            ///< used by the timer alone
  SlamDiagnostics diagnostics_;
  diagnostic_updater::Updater diagnostic_updater_;
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Publisher pose_publisher_;
  ros::Publisher match_info_publisher_;
  ros::Timer transform_timer_;
  ros::WallTimer diagnostic_timer_;
  ros::WallTimer silence_timer_;
  std::vector<ros::Subscriber> scan_subscribers_;
  ros::Subscriber transform_subscriber_;
  ros::Subscriber static_transform_subscriber_;
  ros::Subscriber initial_pose_subscriber_;
  ros::ServiceServer dynamic_map_service_;
  ros::ServiceServer save_map_service_;
  ros::ServiceServer load_map_service_;
  ros::ServiceServer reset_service_;
  ros::ServiceServer pause_service_;
  ros::ServiceServer relocalise_service_;
  std::unique_ptr<MapPublisher> map_publisher_;
  std::unique_ptr<ReconfigureServer> reconfigure_server_;
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
  std::thread mapping_thread_;
};

}  // namespace matchbox_slam
