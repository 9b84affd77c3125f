#include "run/slam_run.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/thread_time.hpp"

namespace matchbox_slam {

namespace {

/// Drops the older half of what has grown too long.
void keep_recent(std::vector<float>& seconds) {
  constexpr std::ptrdiff_t kRecent = 1000;
  if (seconds.size() >= 2 * kRecent) {
    seconds.erase(seconds.begin(), seconds.end() - kRecent);
  }
}

/// One pose a stamp: of two lasers at one moment the later one knows more.
void add_pose(const StampedPose2& pose, std::vector<StampedPose2>& poses) {
  if (!poses.empty() && poses.back().stamp == pose.stamp) {
    poses.back() = pose;
  } else {
    poses.push_back(pose);
  }
}

}  // namespace

SlamRun::SlamRun(const SlamSetup& setup, RunRecords records)
    : records_(records),
      options_(setup.engine),
      matcher_(std::make_shared<TimedMatcher>(setup.matcher)),
      seed_(static_cast<std::uint64_t>(setup.run.seed)),
      start_{setup.run.start_x, setup.run.start_y, wrap_angle(setup.run.start_theta)} {
  reset();
}

void SlamRun::reset() {
  engine_ = std::make_unique<SlamEngine>(options_, matcher_, seed_, start_);
  scans_ = 0;
  path_ = ThinnedPath();
  odometry_path_ = ThinnedPath();
  trajectory_.clear();
  odometry_.clear();
  match_seconds_.clear();
  scan_seconds_.clear();
  statuses_.clear();
  inserted_ = 0;
}

void SlamRun::start_from(MapStart start) {
  auto engine = std::make_unique<SlamEngine>(options_, matcher_, seed_, start_);
  engine->start_from(std::move(start));
  reset();
  engine_ = std::move(engine);
}

void SlamRun::reconfigure(const SlamSetup& setup) {
  engine_->set_options(setup.engine);
  options_ = setup.engine;
  matcher_ = std::make_shared<TimedMatcher>(setup.matcher);
  engine_->set_matcher(matcher_);
}

ScanOutcome SlamRun::process(const ScanInput& input) {
  const double begin = thread_seconds();
  ScanOutcome outcome = engine_->process(input);

  scan_seconds_.push_back(static_cast<float>(thread_seconds() - begin));
  last_match_seconds_ = matcher_->take_seconds();
  if (last_match_seconds_ > 0.0) {
    match_seconds_.push_back(static_cast<float>(last_match_seconds_));
  }
  if (records_ == RunRecords::kRecent) {
    keep_recent(scan_seconds_);
    keep_recent(match_seconds_);
  }
  record(outcome);
  return outcome;
}

void SlamRun::record(const ScanOutcome& outcome) {
  ++scans_;
  ++statuses_[outcome.match.status];
  inserted_ += outcome.inserted ? 1 : 0;
  path_.add({outcome.stamp, outcome.map_from_base});
  if (outcome.odom_from_base) {
    odometry_path_.add({outcome.stamp, *outcome.odom_from_base});
  }
  if (records_ == RunRecords::kAll) {
    add_pose({outcome.stamp, outcome.map_from_base}, trajectory_);
    if (outcome.odom_from_base) {
      add_pose({outcome.stamp, *outcome.odom_from_base}, odometry_);
    }
  }
}

}  // namespace matchbox_slam
