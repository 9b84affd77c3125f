#include "ros/queue_settings.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ros/imu_heading.hpp"

namespace matchbox_slam {
namespace {

std::vector<Eigen::Isometry3d> laser_poses(const RunOptions& options) {
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i + 2 < options.laser_pose.size(); i += 3) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() << options.laser_pose[i], options.laser_pose[i + 1], 0.0;
    pose.rotate(Eigen::AngleAxisd(options.laser_pose[i + 2], Eigen::Vector3d::UnitZ()));
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace

ScanQueueSettings queue_settings(const RunOptions& options, const ProjectionOptions& projection,
                                 const ScanTimingOptions& timing, double scan_time_offset) {
  ScanQueueSettings settings;
  settings.base_frame = options.base_frame;
  if (options.use_odometry) {
    settings.odom_frame = options.odom_frame;
    settings.odometry_by_topic = !options.odom_topic.empty();
  }
  settings.map_frame = options.map_frame;
  settings.transform_timeout = options.transform_timeout;
  settings.max_waiting = static_cast<std::size_t>(options.queue_size);
  settings.scan_time_offset = ros::Duration(scan_time_offset);
  settings.lasers = std::max(1, static_cast<int>(options.scan_topics.size()));
  settings.max_lag = options.max_lag;
  settings.projection = projection;
  settings.timing = scan_timing(timing);
  settings.use_imu = !options.imu_topic.empty();
  settings.heading_by_imu = settings.use_imu && !options.use_odometry;
  settings.laser_poses = laser_poses(options);
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
  settings.projection = setup.odometry.scan;
  settings.timing = scan_timing(setup.timing);
  return settings;
}

}  // namespace matchbox_slam
