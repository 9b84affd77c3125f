#include "node/slam_input.hpp"

#include <fmt/core.h>
#include <ros/callback_queue.h>
#include <ros/this_node.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "node/subscribe.hpp"
#include "ros/message_conversion.hpp"
#include "run/frames.hpp"

namespace matchbox_slam {

SlamInput::SlamInput(ros::NodeHandle& node, ros::NodeHandle& timer_node, const SlamSetup& setup,
                     ScanWorker& worker, std::function<void(double)> on_no_returns)
    : options_(setup.run),
      callbacks_(node.getCallbackQueue()),
      worker_(worker),
      on_no_returns_(std::move(on_no_returns)),
      clock_watch_(setup.run.map_frame),
      holds_scans_(!fixed_scan_time_offset(setup.run)) {
  subscribe(node, setup.cloud);
  silence_watch_ = std::make_unique<SilenceWatch>(timer_node, [this] { return silent_topics(); });
}

void SlamInput::subscribe(ros::NodeHandle& node, const CloudOptions& cloud) {
  const auto subscribe_to_transforms = [&](const std::string& topic, bool is_static) {
    return subscribe_to_events<tf2_msgs::TFMessage>(
        node, topic, kTransformMessages,
        [this, is_static](const TransformEvent& event) { on_transforms(event, is_static); });
  };
  static_transform_subscriber_ = subscribe_to_transforms("/tf_static", true);
  transform_subscriber_ = subscribe_to_transforms("/tf", false);
  if (!options_.imu_topic.empty()) {
    imu_subscriber_ = subscribe_to_imu(node, options_.imu_topic, worker_);
  }
  if (!options_.odom_topic.empty()) {
    odometry_subscriber_ = subscribe_to_odometry(node, options_.odom_topic, worker_);
  }
  const std::vector<std::string> topics =
      options_.scan_topics.empty() ? std::vector<std::string>{"scan"} : options_.scan_topics;
  for (int laser = 0; laser < static_cast<int>(topics.size()); ++laser) {
    scan_subscribers_.push_back(
        subscribe_to_scans(node, topics[static_cast<std::size_t>(laser)], cloud,
                           [this, laser](const ScanArrival& scan) { on_scan(scan, laser); }));
  }
}

std::vector<std::string> SlamInput::topics() const {
  std::vector<std::string> topics;
  for (const ros::Subscriber& subscriber : scan_subscribers_) {
    topics.push_back(subscriber.getTopic());
  }
  return topics;
}

/// Under load, scans may wait in roscpp's buffers; the account of an ended run has them, too.
void SlamInput::take_what_has_come() {
  is_ending_ = true;
  if (auto* const callbacks = dynamic_cast<ros::CallbackQueue*>(callbacks_)) {  // not a nodelet's
    callbacks->callAvailable();
  }
}

void SlamInput::stop() {
  take_what_has_come();
  for (ros::Subscriber& subscriber : scan_subscribers_) {
    subscriber.shutdown();
  }
  imu_subscriber_.shutdown();
  odometry_subscriber_.shutdown();
  transform_subscriber_.shutdown();
  static_transform_subscriber_.shutdown();
  silence_watch_->stop();
  worker_.use_queue([&](ScanQueue& queue) { release_scans(ros::Time::now(), queue); });
}

std::size_t SlamInput::held_scans() {
  std::size_t held = 0;
  worker_.use_queue([&](ScanQueue& /*queue*/) { held = held_scans_.size(); });
  return held;
}

std::string SlamInput::rivals() {
  std::string text;
  worker_.use_queue([&](ScanQueue& /*queue*/) { text = rivals_; });
  return text;
}

double SlamInput::untold_clock_offset() {
  double offset = 0.0;
  worker_.use_queue([&](ScanQueue& /*queue*/) { offset = untold_clock_offset_; });
  return offset;
}

void SlamInput::on_scan(const ScanArrival& scan, int laser) {
  std::optional<double> no_returns_from;
  worker_.use_queue([&](ScanQueue& queue) {
    heard_lasers_.insert(laser);
    no_returns_from = look_for_no_returns(scan.message, laser);
    clock_watch_.add_scan(scan.message.scan->header.stamp, scan.time);
    settle_clocks(scan.time, queue);
    if (holds_scans_) {
      held_scans_.emplace_back(scan, laser);
    } else {
      queue.add_scan(scan.message, scan.time, laser);
    }
  });
  if (no_returns_from) {
    std::exchange(on_no_returns_, nullptr)(*no_returns_from);
  }
}

void SlamInput::on_transforms(const TransformEvent& event, bool is_static) {
  if (is_ending_) {
    return;  // no scan is used any more
  }
  worker_.use_queue([&](ScanQueue& queue) {
    if (!is_static) {
      clock_watch_.add_transforms(*event.getConstMessage(), event.getReceiptTime());
    }
    settle_clocks(event.getReceiptTime(), queue);
    queue.add_transforms(*event.getConstMessage(), is_static, event.getReceiptTime());
    warn_of_map_link(event);
    if (!is_static) {
      warn_of_second_odometry(event);
    }
  });
}

/// Tells once whether the clocks of scans and tf differ; with 'auto' the scans held back go on
/// then.
void SlamInput::settle_clocks(const ros::Time& now, ScanQueue& queue) {
  const std::optional<double> offset = clock_watch_.conclude(now);
  if (!offset) {
    return;
  }
  const double applied = fixed_scan_time_offset(options_).value_or(*offset);
  if (std::abs(*offset - applied) > kMinToldClockOffset) {
    untold_clock_offset_ = *offset;
    ROS_WARN_STREAM("the clocks of scans and tf differ: scans are "
                    << std::abs(*offset) << " s " << (*offset > 0.0 ? "behind" : "ahead")
                    << "; to correct that set scan_time_offset to auto or " << *offset);
  } else if (applied != 0.0) {
    ROS_INFO_STREAM("stamps of scans are moved by " << applied << " s to the clock of tf");
  }
  if (holds_scans_) {
    queue.set_scan_time_offset(ros::Duration(applied));
    release_scans(now, queue);
  }
}

void SlamInput::release_scans(const ros::Time& now, ScanQueue& queue) {
  for (const auto& [scan, laser] : held_scans_) {
    queue.add_scan(scan.message, now, laser);
  }
  held_scans_.clear();
  holds_scans_ = false;
}

std::vector<std::string> SlamInput::silent_topics() {
  std::vector<std::string> silent;
  worker_.use_queue([&](ScanQueue& /*queue*/) {
    for (std::size_t laser = 0; laser < scan_subscribers_.size(); ++laser) {
      if (heard_lasers_.count(static_cast<int>(laser)) == 0) {
        silent.push_back(scan_subscribers_[laser].getTopic());
      }
    }
  });
  return silent;
}

std::optional<double> SlamInput::look_for_no_returns(const ScanMessage& message, int laser) {
  const sensor_msgs::LaserScan& scan = *message.scan;
  if (!on_no_returns_) {
    return std::nullopt;
  }
  MaxRangeDetector& detector = no_returns_[laser];
  if (!detector.is_complete() && find_defect(scan).empty()) {
    detector.add(to_laser_scan(scan));
    return detector.first_range();
  }
  return std::nullopt;
}

void SlamInput::warn_of_map_link(const TransformEvent& event) {
  const std::string& publisher = event.getPublisherName();
  if (told_of_map_link_ || publisher == ros::this_node::getName()) {  // what we publish comes back
    return;
  }
  const std::string link = find_map_link(*event.getConstMessage(), options_.map_frame);
  if (!link.empty()) {
    rivals_ = fmt::format(
        "tf that touches the map frame is ignored: {}, published by {}; if that is another "
        "localiser, set publish_tf to false or stop it",
        link, publisher);
    ROS_WARN_STREAM(rivals_);
    told_of_map_link_ = true;
  }
}

/// Two that take turns: the odometry would leap to and fro. One that is started again under
/// another name is none.
void SlamInput::warn_of_second_odometry(const TransformEvent& event) {
  constexpr double kTurn = 0.5;  // [s] in which both are heard
  const std::string& publisher = event.getPublisherName();
  const auto& links = event.getConstMessage()->transforms;
  const bool is_odometry = std::any_of(links.begin(), links.end(), [this](const auto& link) {
    return without_leading_slash(link.header.frame_id) == options_.odom_frame;
  });
  if (!is_odometry || told_of_second_odometry_ || !options_.use_odometry ||
      !options_.odom_topic.empty()) {
    return;
  }
  const ros::Time now = event.getReceiptTime();
  const auto before = odometry_nodes_.find(publisher);
  for (const auto& [other, heard] : odometry_nodes_) {
    const bool in_turn = before != odometry_nodes_.end() && heard >= before->second &&
                         std::abs(seconds_between(heard, now)) < kTurn;
    if (other != publisher && in_turn) {
      rivals_ = fmt::format(
          "two nodes publish tf from the odometry frame '{}': {} and {}; if both mean the base, "
          "stop one of them, or the pose leaps to and fro",
          options_.odom_frame, other, publisher);
      ROS_WARN_STREAM(rivals_);
      told_of_second_odometry_ = true;
      break;
    }
  }
  odometry_nodes_[publisher] = now;
}

}  // namespace matchbox_slam
