#pragma once

#include <ros/callback_queue_interface.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <tf2_msgs/TFMessage.h>

#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "node/scan_subscription.hpp"
#include "node/scan_worker.hpp"
#include "node/silence_watch.hpp"
#include "ros/clock_watch.hpp"
#include "run/slam_setup.hpp"
#include "sensor/max_range_detector.hpp"

namespace matchbox_slam {

/// Puts the scans and transforms that come in into the worker's queue, and tells in the log when
/// something is odd about them: clocks that differ, silence, tf that touches the map frame.
class SlamInput {
 public:
  /// Subscribes at once. @param timer_node  whose callback queue watches for silence.
  /// @param on_no_returns  called once with the range [m] from which on beams of a laser are found
  ///                       to be no return; null: nobody wants to know.
  SlamInput(ros::NodeHandle& node, ros::NodeHandle& timer_node, const SlamSetup& setup,
            ScanWorker& worker, std::function<void(double)> on_no_returns);

  /// Of the scans, with what they are remapped to.
  [[nodiscard]] std::vector<std::string> topics() const;

  /// No more messages come; all scans that came are in the queue.
  void stop();

  /// Who publishes tf of the map frame or of the odometry besides who should, as the log has said;
  /// empty: nobody.
  [[nodiscard]] std::string rivals();

  /// Scans that are not in the queue yet.
  [[nodiscard]] std::size_t held_scans();
  /// [s] that scans should be moved by and are not.
  [[nodiscard]] double untold_clock_offset();

 private:
  using TransformEvent = ros::MessageEvent<const tf2_msgs::TFMessage>;

  void subscribe(ros::NodeHandle& node, const CloudOptions& cloud);
  void take_what_has_come();
  void on_scan(const ScanArrival& scan, int laser);
  void on_transforms(const TransformEvent& event, bool is_static);
  void settle_clocks(const ros::Time& now, ScanQueue& queue);
  void release_scans(const ros::Time& now, ScanQueue& queue);
  std::vector<std::string> silent_topics();
  void warn_of_map_link(const TransformEvent& event);
  void warn_of_second_odometry(const TransformEvent& event);
  std::optional<double> look_for_no_returns(const ScanMessage& message, int laser);

  const RunOptions options_;
  ros::CallbackQueueInterface* callbacks_;  ///< in which messages wait for this object
  std::atomic<bool> is_ending_{false};
  ScanWorker& worker_;
  std::function<void(double)> on_no_returns_;  ///< null when it has been called
  ClockWatch clock_watch_;                     ///< as what follows, used only while the queue is
  bool holds_scans_;                           ///< until the offset of their clock is known
  std::deque<std::pair<ScanArrival, int>> held_scans_;
  double untold_clock_offset_ = 0.0;
  std::set<int> heard_lasers_;
  bool told_of_map_link_ = false;
  std::string rivals_;                               ///< for people
  std::map<std::string, ros::Time> odometry_nodes_;  ///< when each has told where the base is last
  bool told_of_second_odometry_ = false;
  std::map<int, MaxRangeDetector> no_returns_;  ///< by laser

  std::vector<ros::Subscriber> scan_subscribers_;
  ros::Subscriber imu_subscriber_;
  ros::Subscriber odometry_subscriber_;
  ros::Subscriber transform_subscriber_;
  ros::Subscriber static_transform_subscriber_;
  std::unique_ptr<SilenceWatch> silence_watch_;
};

}  // namespace matchbox_slam
