#include "matchbox_slam/ros/slam_run.hpp"

#include "matchbox_slam/common/thread_time.hpp"

namespace matchbox_slam {

ScanQueueSettings queue_settings(const RunOptions& options, double scan_time_offset) {
  ScanQueueSettings settings;
  settings.base_frame = options.base_frame;
  if (options.use_odometry) {
    settings.odom_frame = options.odom_frame;
  }
  settings.map_frame = options.map_frame;
  settings.transform_timeout = options.transform_timeout;
  settings.max_waiting = static_cast<std::size_t>(options.queue_size);
  settings.scan_time_offset = ros::Duration(scan_time_offset);
  settings.stop_at_time_jump = options.time_jump == "stop";
  return settings;
}

SlamRun::SlamRun(const SlamSetup& setup)
    : options_(setup.engine),
      matcher_(std::make_shared<TimedMatcher>(setup.matcher)),
      seed_(static_cast<std::uint64_t>(setup.run.seed)),
      start_{setup.run.start_x, setup.run.start_y, wrap_angle(setup.run.start_theta)} {
  reset();
}

void SlamRun::reset() {
  engine_ = std::make_unique<SlamEngine>(options_, matcher_, seed_, start_);
  trajectory_.clear();
  odometry_.clear();
  match_seconds_.clear();
  scan_seconds_.clear();
  statuses_.clear();
  inserted_ = 0;
}

ScanOutcome SlamRun::process(const ScanInput& input) {
  const double begin = thread_seconds();
  ScanOutcome outcome = engine_->process(input);

  scan_seconds_.push_back(static_cast<float>(thread_seconds() - begin));
  if (const double seconds = matcher_->take_seconds(); seconds > 0.0) {
    match_seconds_.push_back(static_cast<float>(seconds));
  }
  ++statuses_[outcome.match.status];
  inserted_ += outcome.inserted ? 1 : 0;
  trajectory_.push_back({outcome.stamp, outcome.map_from_base});
  if (outcome.odom_from_base) {
    odometry_.push_back({outcome.stamp, *outcome.odom_from_base});
  }
  return outcome;
}

}  // namespace matchbox_slam
