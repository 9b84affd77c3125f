#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/timer.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "ros/scan_queue.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// Publishes what became of each scan, as pose and match_info, and the transform from the map to
/// the odometry, or to the base where there is none: at once, and in between by a timer. What else
/// the robot's pose may be it publishes as particlecloud, as amcl does, and with weights as
/// likely_poses.
class PosePublisher {
 public:
  PosePublisher(ros::NodeHandle& node, const SlamSetup& setup);

  /// @param matcher  lookup name of the one that was used.
  void publish(const ReadyScan& scan, const ScanOutcome& outcome, double match_seconds,
               const std::string& matcher);
  /// Where else the robot may be at that scan.
  void publish_likely(const ReadyScan& scan, const std::vector<WeightedPose>& likely);

  /// The map is given up, or odometry has begun anew: no transform until the next scan.
  void forget();

  /// Options that may change: publish_tf, transform_tolerance, tf_while_lost.
  void set_options(const SlamNodeOptions& options);

  /// No more transforms.
  void stop() { timer_.stop(); }

 private:
  void publish_pose(const ReadyScan& scan, const ScanOutcome& outcome);
  void publish_match_info(const ReadyScan& scan, const ScanOutcome& outcome, double match_seconds,
                          const std::string& matcher);
  [[nodiscard]] geometry_msgs::TransformStamped map_transform(const ReadyScan& scan,
                                                              const ScanOutcome& outcome) const;
  void choose_transform(const ReadyScan& scan, const ScanOutcome& outcome);  ///< under the mutex
  void repeat_transform();
  void publish_transform(const ros::Time& now);  ///< under the mutex

  const RunOptions options_;
  const double transform_period_;  ///< [s]
  std::atomic<bool> publish_tf_;
  std::atomic<double> transform_tolerance_;  ///< [s]
  std::mutex mutex_;                         ///< guards the next five
  std::string tf_while_lost_;
  std::optional<geometry_msgs::TransformStamped> map_transform_;   ///< that is published
  std::optional<geometry_msgs::TransformStamped> sure_transform_;  ///< the last one that was sure
  ros::Time last_transform_time_;
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Publisher pose_;
  ros::Publisher match_info_;
  ros::Publisher particles_;
  ros::Publisher likely_poses_;
  ros::Timer timer_;
};

}  // namespace matchbox_slam
