#include "node/silence_watch.hpp"

#include <ros/console.h>
#include <ros/master.h>

#include <utility>

#include "matchbox_slam/common/options.hpp"
#include "ros/scan_message.hpp"

namespace matchbox_slam {
namespace {

// After so long without a scan, the log says so, and again after so long [s].
constexpr double kPatience = 5.0;
constexpr double kReminder = 60.0;

std::vector<std::string> topics_with_scans() {
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  std::vector<std::string> names;
  for (const ros::master::TopicInfo& topic : topics) {
    if (is_scan_type(topic.datatype)) {
      names.push_back(topic.name);
    }
  }
  return names;
}

}  // namespace

SilenceWatch::SilenceWatch(ros::NodeHandle& timer_node,
                           std::function<std::vector<std::string>()> silent_topics)
    : silent_topics_(std::move(silent_topics)),
      // By the wall clock, so that it goes on when simulated time stands still.
      timer_(timer_node.createWallTimer(
          ros::WallDuration(kPatience),
          [this](const ros::WallTimerEvent& /*event*/) { warn_of_silence(); })) {}

void SilenceWatch::warn_of_silence() {
  const std::vector<std::string> silent = silent_topics_();
  if (silent.empty()) {
    timer_.stop();
    return;
  }
  if (!ros::master::check()) {
    return;  // to ask a master that is gone would take until ROS ends
  }
  const std::vector<std::string> there = topics_with_scans();
  ROS_WARN_STREAM("no scan has come from "
                  << join(silent) << " yet; "
                  << (there.empty() ? "nobody publishes scans"
                                    : "scans are published on " + join(there)));
  timer_.setPeriod(ros::WallDuration(kReminder));
}

}  // namespace matchbox_slam
