#pragma once

#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include <functional>
#include <string>
#include <vector>

namespace matchbox_slam {

/// Tells in the log that no scan has come from some topics, and where there are scans: a wrong name
/// of a topic would show by nothing else.
class SilenceWatch {
 public:
  /// Begins at once. @param timer_node  whose callback queue watches, and calls the other.
  /// @param silent_topics  those that no scan has come from yet; none ends the watch.
  SilenceWatch(ros::NodeHandle& timer_node,
               std::function<std::vector<std::string>()> silent_topics);

  /// Nobody is asked any more.
  void stop() { timer_.stop(); }

 private:
  void warn_of_silence();

  std::function<std::vector<std::string>()> silent_topics_;
  ros::WallTimer timer_;
};

}  // namespace matchbox_slam
