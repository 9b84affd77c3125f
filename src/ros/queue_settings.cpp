#include "ros/queue_settings.hpp"

#include <algorithm>
#include <cstddef>

#include "ros/imu_heading.hpp"

namespace matchbox_slam {
ScanQueueSettings queue_settings(const RunOptions& options, double max_tilt,
                                 const ScanTimingOptions& timing, double scan_time_offset) {
  ScanQueueSettings settings;
  settings.base_frame = options.base_frame;
  if (options.use_odometry) {
    settings.odom_frame = options.odom_frame;
  }
  settings.map_frame = options.map_frame;
  settings.transform_timeout = options.transform_timeout;
  settings.max_waiting = static_cast<std::size_t>(options.queue_size);
  settings.scan_time_offset = ros::Duration(scan_time_offset);
  settings.lasers = std::max(1, static_cast<int>(options.scan_topics.size()));
  settings.max_lag = options.max_lag;
  settings.max_tilt = max_tilt;
  settings.timing = scan_timing(timing);
  settings.use_imu = !options.imu_topic.empty();
  settings.stop_at_time_jump = options.time_jump == "stop";
  return settings;
}

ScanQueueSettings queue_settings(const ScanMatcherSetup& setup) {
  ScanQueueSettings settings;
  settings.base_frame = setup.node.base_frame;
  if (setup.guess == GuessSource::kOdometry) {
    settings.odom_frame = setup.node.guess_frame;
  } else if (setup.guess == GuessSource::kHeading) {
    settings.odom_frame = kImuHeadingFrame;
  }
  // What we publish comes back to us, and is no news.
  settings.map_frame = setup.node.publish_tf ? setup.node.odom_frame : "";
  settings.transform_timeout = setup.node.transform_timeout;
  settings.max_waiting = static_cast<std::size_t>(setup.node.queue_size);
  settings.scan_time_offset = ros::Duration(setup.node.scan_time_offset);
  settings.max_tilt = setup.odometry.scan.max_tilt;
  settings.timing = scan_timing(setup.timing);
  return settings;
}

}  // namespace matchbox_slam
