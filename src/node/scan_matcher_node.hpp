#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "matchbox_slam/odometry/laser_odometry.hpp"
#include "node/scan_matcher_diagnostics.hpp"
#include "node/scan_worker.hpp"
#include "node/silence_watch.hpp"
#include "ros/matcher_loader.hpp"
#include "run/scan_matcher_setup.hpp"
#include "run/timed_matcher.hpp"

namespace matchbox_slam {

/// A link that gives `child` a parent, as "odom -> base_link"; empty: there is none in the message.
/// @param own_parent  links from this frame count only if `from_others`.
[[nodiscard]] std::string find_rival_link(const tf2_msgs::TFMessage& message,
                                          const std::string& child, const std::string& own_parent,
                                          bool from_others);

/// The laser odometry node: scans in, odometry out, no map. Callbacks only fill the queue; the
/// worker's thread does the matching.
class ScanMatcherNode {
 public:
  /// Starts at once. Throws ConfigurationError for private parameters that are unknown or not
  /// allowed.
  ScanMatcherNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ~ScanMatcherNode();

  ScanMatcherNode(const ScanMatcherNode&) = delete;
  ScanMatcherNode& operator=(const ScanMatcherNode&) = delete;

 private:
  void subscribe();
  void on_transforms(const ros::MessageEvent<const tf2_msgs::TFMessage>& event, bool is_static);
  void look_for_rival(const ros::MessageEvent<const tf2_msgs::TFMessage>& event);

  void handle(const ScanQueue::Item& item);
  void match_scan(const ReadyScan& scan);
  void warn_of_failure(const LaserOdometryOutcome& outcome) const;
  void publish(const ReadyScan& scan, const LaserOdometryOutcome& outcome, bool with_tf);
  void start_anew();
  void start_diagnostics();
  void update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  MatcherLoader loader_;
  ScanMatcherSetup setup_;
  std::shared_ptr<TimedMatcher> matcher_;
  ros::CallbackQueue diagnostic_queue_;  ///< before all that puts callbacks in it

  ScanWorker worker_;
  std::mutex mutex_;         ///< guards the next two
  std::string tf_conflict_;  ///< why no tf is published; empty: it is, or is not wanted
  MatchRecord matches_;

  std::unique_ptr<LaserOdometry> odometry_;  ///< of the worker's thread, as what follows
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Publisher odometry_publisher_;

  ScanMatcherDiagnostics diagnostics_;
  diagnostic_updater::Updater diagnostic_updater_;
  ros::WallTimer diagnostic_timer_;
  std::atomic<bool> is_heard_{false};  ///< whether a scan has come
  ros::Subscriber scan_subscriber_;
  ros::Subscriber imu_subscriber_;
  ros::Subscriber transform_subscriber_;
  ros::Subscriber static_transform_subscriber_;
  std::unique_ptr<SilenceWatch> silence_watch_;
  std::unique_ptr<ros::AsyncSpinner> diagnostic_spinner_;
};

}  // namespace matchbox_slam
