#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/GetMap.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Empty.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/MergeMap.h"
#include "matchbox_slam/Relocalise.h"
#include "matchbox_slam/SetPoseAtStamp.h"
#include "matching/hough/relocalise.hpp"
#include "node/autosave.hpp"
#include "node/late_log.hpp"
#include "node/map_publisher.hpp"
#include "node/pose_publisher.hpp"
#include "node/reconfigure_server.hpp"
#include "node/scan_worker.hpp"
#include "node/slam_diagnostics.hpp"
#include "node/slam_input.hpp"
#include "ros/matcher_loader.hpp"
#include "run/map_saver.hpp"
#include "run/other_maps.hpp"
#include "run/slam_session.hpp"

namespace matchbox_slam {

/// Of a run, and the node's own.
[[nodiscard]] std::vector<OptionDescription> describe_node_options();

/// The SLAM node: messages in, the same queue and run as in map_bag, messages out. Callbacks only
/// fill the queue; the worker's thread does the mapping, another publishes maps. What changes the
/// mapping goes through the queue too, as an event. Two more threads answer services: one those
/// that may wait for scans or search for long, the other the rest, so that none waits for those.
class SlamNode {
 public:
  /// Starts at once. Throws ConfigurationError for private parameters that are unknown or not
  /// allowed, and FileError when a file cannot be written, or the initial map not be read, or not
  /// the one to resume where it is only to be localised in.
  SlamNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node);

  /// Ends after the scan at hand, then writes trajectory and events, and the map where it is saved
  /// by itself.
  ~SlamNode();

  SlamNode(const SlamNode&) = delete;
  SlamNode& operator=(const SlamNode&) = delete;

 private:
  void begin_map();
  [[nodiscard]] EngineState read_resumed(const std::string& file);
  void set_map_aside(const std::string& path, const std::string& why);
  void start_services();
  void cut_no_returns(double from);
  void on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message);

  // In the worker's thread.
  void handle(const ReadyScan& scan);
  void handle(const TimeJump& jump);
  void handle(const RunEvent& event);
  void handle(const LeftOut& left_out);
  void forget_map();
  void adopt_options(const SlamSetup& setup);
  void remember_health(const ReadyScan& scan, const ScanOutcome& outcome);

  bool answer_dynamic_map(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool answer_save_map(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool answer_global_localization(std_srvs::Empty::Request& request,
                                  std_srvs::Empty::Response& response);
  bool answer_load_map(LoadMap::Request& request, LoadMap::Response& response);
  bool answer_merge_map(MergeMap::Request& request, MergeMap::Response& response);
  bool answer_reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool answer_pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool answer_relocalise(Relocalise::Request& request, Relocalise::Response& response);
  bool answer_set_pose_at_stamp(SetPoseAtStamp::Request& request,
                                SetPoseAtStamp::Response& response);
  std::string try_to_correct_pose(const Relocalisation& found, double stamp);
  std::vector<OptionDescription> reconfigure(const Parameters& changes);
  void update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status);

  [[nodiscard]] const SlamRun& run() const { return session_.run(); }
  [[nodiscard]] SlamSetup setup();
  [[nodiscard]] LoadMapFile read_load(const std::string& path);
  void require_mergeable(const EngineState& map);
  [[nodiscard]] OwnMap own_map();
  [[nodiscard]] MapRevision map_revision();
  [[nodiscard]] MapSnapshot map_snapshot();
  [[nodiscard]] PathSnapshot path_snapshot();
  [[nodiscard]] MapToSave read_map_to_save();
  void require_used_scan();
  std::string save_map_files();
  [[nodiscard]] bool is_saved();
  [[nodiscard]] std::size_t unsaved_scans();
  void tell_unsaved();
  void autosave();
  void finish_loops();
  void save_records();

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  ros::CallbackQueue prompt_queue_;   ///< of callbacks that never wait for scans; as the next one,
                                      ///< before all that puts callbacks in it
  ros::CallbackQueue patient_queue_;  ///< of those that may
  MatcherLoader loader_;

  LateLog log_;           ///< of what is said while the next is held
  std::mutex run_mutex_;  ///< guards what follows, up to the worker
  SlamSession session_;
  std::optional<ReadyScan> newest_scan_;
  std::deque<ScanHealth> recent_;
  std::string set_aside_;  ///< where a map is that could not be resumed, until this one is given up

  std::mutex save_mutex_;  ///< held while files of the map are written, as what follows
  MapSaver saver_;
  ScanWorker worker_;
  const RunOptions options_;  ///< what of the configuration does not change
  const std::string trajectory_file_;
  const std::string events_file_;

  PosePublisher poses_;
  SlamDiagnostics diagnostics_;
  diagnostic_updater::Updater diagnostic_updater_;
  ros::WallTimer diagnostic_timer_;
  ros::Subscriber initial_pose_subscriber_;
  std::vector<ros::ServiceServer> services_;
  std::unique_ptr<MapPublisher> map_publisher_;
  std::unique_ptr<ReconfigureServer> reconfigure_server_;
  std::unique_ptr<SlamInput> input_;
  std::unique_ptr<OtherMaps> other_maps_;
  std::unique_ptr<Autosave> autosave_;  ///< null: the map is saved only when that is asked for
  std::vector<std::unique_ptr<ros::AsyncSpinner>> spinners_;
};

}  // namespace matchbox_slam
