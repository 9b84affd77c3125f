// What the SLAM node does with messages as they come in.

#include <ros/master.h>
#include <ros/message_traits.h>

#include <cmath>

#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"

namespace matchbox_slam {
namespace {

// Generous, since a message lost here is lost uncounted.
constexpr std::uint32_t kScanMessages = 1000;
constexpr std::uint32_t kTransformMessages = 10000;

// From one warning that no scan comes to the next [s].
constexpr double kReminder = 60.0;

std::vector<std::string> topics_with_scans() {
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  std::vector<std::string> names;
  for (const ros::master::TopicInfo& topic : topics) {
    if (topic.datatype == ros::message_traits::datatype<sensor_msgs::LaserScan>()) {
      names.push_back(topic.name);
    }
  }
  return names;
}

}  // namespace

void SlamNode::subscribe() {
  using TransformEvent = ros::MessageEvent<const tf2_msgs::TFMessage>;
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  const auto subscribe_to_transforms = [&](const std::string& topic, bool is_static) {
    return node_.subscribe<tf2_msgs::TFMessage>(
        topic, kTransformMessages,
        [this, is_static](const TransformEvent& event) { on_transforms(event, is_static); },
        ros::VoidConstPtr(), hints);
  };
  static_transform_subscriber_ = subscribe_to_transforms("/tf_static", true);
  transform_subscriber_ = subscribe_to_transforms("/tf", false);
  const std::vector<std::string> topics =
      options_.scan_topics.empty() ? std::vector<std::string>{"scan"} : options_.scan_topics;
  std::vector<std::string> resolved;
  for (int laser = 0; laser < static_cast<int>(topics.size()); ++laser) {
    scan_subscribers_.push_back(node_.subscribe<sensor_msgs::LaserScan>(
        topics[static_cast<std::size_t>(laser)], kScanMessages,
        [this, laser](const ScanEvent& event) { on_scan(event, laser); }, ros::VoidConstPtr(),
        hints));
    resolved.push_back(scan_subscribers_.back().getTopic());
  }
  initial_pose_subscriber_ =
      node_.subscribe("initialpose", 10, &SlamNode::on_initial_pose, this, hints);
  ROS_INFO_STREAM("mapping with " << configuration_.setup().matcher_name << ": scans from "
                                  << join(resolved) << ", frames " << options_.map_frame << ", "
                                  << (options_.use_odometry ? options_.odom_frame + ", " : "")
                                  << options_.base_frame);
}

void SlamNode::on_scan(const ScanEvent& event, int laser) {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    const sensor_msgs::LaserScan& scan = *event.getConstMessage();
    heard_lasers_.insert(laser);
    clock_watch_.add_scan(scan.header.stamp, event.getReceiptTime());
    settle_clocks(event.getReceiptTime());
    if (holds_scans_) {
      held_scans_.emplace_back(event, laser);
    } else {
      queue_.add_scan(scan, event.getReceiptTime(), laser);
    }
    skip_warnings_.tell(queue_);
  }
  queue_changed_.notify_one();
}

void SlamNode::on_transforms(const ros::MessageEvent<const tf2_msgs::TFMessage>& event,
                             bool is_static) {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    if (!is_static) {
      clock_watch_.add_transforms(*event.getConstMessage(), event.getReceiptTime());
    }
    settle_clocks(event.getReceiptTime());
    queue_.add_transforms(*event.getConstMessage(), is_static, event.getReceiptTime());
    warn_of_map_link(event);
    skip_warnings_.tell(queue_);
  }
  queue_changed_.notify_one();
}

/// Tells once whether the clocks of scans and tf differ; with 'auto' the scans held back go on
/// then.
void SlamNode::settle_clocks(const ros::Time& now) {
  const std::optional<double> offset = clock_watch_.conclude(now);
  if (!offset) {
    return;
  }
  const double applied = fixed_scan_time_offset(options_).value_or(*offset);
  if (std::abs(*offset - applied) > kClockOffsetWorthTelling) {
    untold_clock_offset_ = *offset;
    ROS_WARN_STREAM("the clocks of scans and tf differ: scans are "
                    << std::abs(*offset) << " s " << (*offset > 0.0 ? "behind" : "ahead")
                    << "; to correct that set scan_time_offset to auto or " << *offset);
  } else if (applied != 0.0) {
    ROS_INFO_STREAM("stamps of scans are moved by " << applied << " s to the clock of tf");
  }
  if (holds_scans_) {
    queue_.set_scan_time_offset(ros::Duration(applied));
    for (const auto& [event, laser] : held_scans_) {
      queue_.add_scan(*event.getConstMessage(), now, laser);
    }
    held_scans_.clear();
    holds_scans_ = false;
  }
}

void SlamNode::on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const std::string frame = without_leading_slash(message.header.frame_id);
  if (frame != options_.map_frame) {
    ROS_WARN_STREAM("initialpose in frame '" << frame << "' is ignored; it has to be in '"
                                             << options_.map_frame << "'");
    return;
  }
  if (const std::string defect = find_defect(message.pose); !defect.empty()) {
    ROS_WARN_STREAM("initialpose is ignored: " << defect);
    return;
  }
  const std::lock_guard<std::mutex> lock(run_mutex_);
  run_.set_pose(to_pose2(message.pose.pose), plane_covariance(message.pose));
}

/// A wrong name of a topic would show by nothing else.
void SlamNode::warn_of_silence() {
  std::vector<std::string> silent;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    for (std::size_t laser = 0; laser < scan_subscribers_.size(); ++laser) {
      if (heard_lasers_.count(static_cast<int>(laser)) == 0) {
        silent.push_back(scan_subscribers_[laser].getTopic());
      }
    }
  }
  if (silent.empty()) {
    silence_timer_.stop();
    return;
  }
  const std::vector<std::string> there = topics_with_scans();
  ROS_WARN_STREAM("no scan has come from "
                  << join(silent) << " yet; "
                  << (there.empty() ? "nobody publishes scans"
                                    : "scans are published on " + join(there)));
  silence_timer_.setPeriod(ros::WallDuration(kReminder));
}

void SlamNode::warn_of_map_link(const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
  // What we publish comes back to us; within a process roscpp does not name the publisher.
  const std::string& publisher = event.getPublisherName();
  if (told_of_map_link_ || publisher == ros::this_node::getName() ||
      publisher == "unknown_publisher") {
    return;
  }
  const std::string link = find_map_link(*event.getConstMessage(), options_.map_frame);
  if (!link.empty()) {
    ROS_WARN_STREAM("tf that touches the map frame is ignored: "
                    << link << ", published by " << publisher
                    << "; if that is another localiser, set publish_tf to false or stop it");
    told_of_map_link_ = true;
  }
}

}  // namespace matchbox_slam
