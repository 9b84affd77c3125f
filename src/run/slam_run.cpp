#include "run/slam_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <variant>

#include "common/append.hpp"
#include "common/thread_time.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "run/start_map.hpp"

namespace matchbox_slam {

namespace {

// How well a scan is placed among key scans: [m], [rad]. Two cells, and a point 2 m away by as
// much: guesses, half and double were not tried.
constexpr double kFoundPosition = 0.1;
constexpr double kFoundHeading = 0.05;

/// Drops the older half of what has grown too long.
template <typename Value>
void keep_recent(std::vector<Value>& values) {
  constexpr std::ptrdiff_t kRecentRecords = 1000;
  if (values.size() >= 2 * kRecentRecords) {
    values.erase(values.begin(), values.end() - kRecentRecords);
  }
}

/// One pose a stamp: of two lasers at one moment the later one knows more.
void add_pose(const StampedPose2& pose, std::vector<StampedPose2>& poses) {
  if (!poses.empty() && poses.back().stamp == pose.stamp) {
    poses.back() = pose;
  } else {
    append_sparingly(pose, poses);
  }
}

std::optional<double> newest_stamp_of(const KeyScans& keys) {
  std::optional<double> newest;
  for (const PlacedScan& key : keys.all()) {
    newest = std::max(newest.value_or(key.scan->stamp()), key.scan->stamp());
  }
  return newest;
}

void correct(const MapCorrection& correction, std::vector<StampedPose2>& poses) {
  auto step = correction.steps.begin();
  for (StampedPose2& pose : poses) {
    while (step + 1 != correction.steps.end() && (step + 1)->since <= pose.stamp) {
      ++step;
    }
    pose.pose = step->new_from_old * pose.pose;
  }
}

}  // namespace

SlamRun::SlamRun(LiveConfiguration configuration, RunRecords records)
    : records_(records),
      configuration_(std::move(configuration)),
      matcher_(std::make_shared<TimedMatcher>(setup().matcher)),
      engine_(make_engine()) {}

std::unique_ptr<SlamEngine> SlamRun::make_engine() const {
  const RunOptions& options = setup().run;
  return std::make_unique<SlamEngine>(
      setup().engine, matcher_, static_cast<std::uint64_t>(options.seed),
      Pose2{options.start_x, options.start_y, wrap_angle(options.start_theta)});
}

void SlamRun::start_with(std::unique_ptr<SlamEngine> engine) {
  engine_ = std::move(engine);
  clocks_.assign(1, {});
  has_stepped_back_ = false;
  is_told_ = false;
  is_anywhere_ = false;
  brought_loops_ = all_loops();
  ++resets_;
  scans_ = 0;
  path_ = ThinnedPath();
  odometry_path_ = ThinnedPath();
  trajectory_.clear();
  live_trajectory_.clear();
  disconnected_.clear();
  is_disconnected_ = false;
  told_.reset();
  odometry_.clear();
  match_seconds_.clear();
  scan_seconds_.clear();
  statuses_.clear();
  certainties_.clear();
  states_.clear();
  evidences_.clear();
  inserted_ = 0;
  left_out_ = 0;
  components_given_up_ = 0;
}

bool SlamRun::take_up(EngineState saved, double stamp, double longest_pause,
                      const std::optional<Pose2>& odom_from_base) {
  const bool same_drive = is_same_drive(stamp, saved.motion.stamp, longest_pause) ||
                          does_odometry_go_on(saved.motion.odom_from_base, odom_from_base,
                                              stamp - saved.motion.stamp.value_or(stamp));
  const bool has_key_scans = !saved.key_scans.empty();
  if (!same_drive) {
    set_initial_pose(setup().run, saved);
  }
  // Of a map whose clock has stepped back they may be ahead.
  if (const auto newest = newest_stamp_of(saved.key_scans)) {
    const double ahead = *newest - (same_drive ? saved.motion.stamp.value_or(stamp) : stamp);
    if (ahead > 0.0) {
      clocks_.back().offset = ahead;
      saved.shift_clock(ahead);
    }
  }
  start_from(std::move(saved));
  if (!same_drive && has_key_scans) {
    begin_drive(stamp);
  }
  return same_drive;
}

void SlamRun::take_up_at(EngineState saved, const SetPose& told) {
  set_initial_pose(setup().run, saved);
  start_from(std::move(saved));
  apply(told);
}

void SlamRun::begin_drive(double stamp) {
  finish();
  components_given_up_ += engine_->begin_component(stamp + clock_offset()) ? 1 : 0;
}

EngineState SlamRun::snapshot() const {
  EngineState start = engine_->snapshot();
  start.shift_clock(-clock_offset());
  return start;
}

LoopCount SlamRun::all_loops() const {
  const LoopState& state = loop_state();
  return {state.loops.size(), count_closed(state.loops), state.tries};
}

LoopCount SlamRun::new_loops() const {
  const LoopCount all = all_loops();
  return {all.found - brought_loops_.found, all.closed - brought_loops_.closed,
          all.tries - brought_loops_.tries};
}

// --- events ---

void SlamRun::apply(const RunEvent& event) {
  std::visit([this](const auto& one) { take_effect(one); }, event);
  if (records_ == RunRecords::kAll) {
    events_.push_back({{}, event});
    if (auto* load = std::get_if<LoadMapFile>(&events_.back().event)) {
      load->map.reset();  // its path is enough to remember it by
    }
  }
}

void SlamRun::take_effect(const SetPose& event) {
  engine_->set_pose(event.map_from_base, event.covariance);
  is_told_ = true;
  is_anywhere_ = false;
  if (!trajectory_.empty()) {
    told_ = trajectory_.back().stamp;
  }
}

void SlamRun::take_effect(const CorrectPose& event) {
  const double stamp = event.stamp + clock_offset();
  const auto then = std::find_if(trajectory_.rbegin(), trajectory_.rend(),
                                 [&](const StampedPose2& pose) { return pose.stamp == stamp; });
  if (then == trajectory_.rend()) {
    throw std::runtime_error(fmt::format(
        "no scan of {:.6f} s was used for this map, or too many have come after it", event.stamp));
  }
  // Between a pose that was told and one before it there is no motion.
  if (told_ && stamp <= *told_ && trajectory_.back().stamp > *told_) {
    throw std::runtime_error(
        fmt::format("where it was has been told since the scan of {:.6f} s", event.stamp));
  }
  const Pose2 motion = then->pose.inverse() * trajectory_.back().pose;
  take_effect(SetPose{event.map_from_base * motion, covariance_of(kFoundPosition, kFoundHeading)});
}

void SlamRun::take_effect(const BeAnywhere& /*event*/) {
  if (key_scans().empty()) {
    throw std::runtime_error(
        "there are no key scans to search for the robot in: they come as the map is made, with "
        "a .slam file, or with an image that has free ground; tell where the robot is by "
        "initialpose");
  }
  is_told_ = false;
  is_anywhere_ = true;
}

void SlamRun::take_effect(const Reset& /*event*/) { start_with(make_engine()); }

void SlamRun::take_effect(const LoadMapFile& event) {
  auto engine = make_engine();
  engine->start_from(*event.map);
  start_with(std::move(engine));
}

void SlamRun::take_effect(const Pause& event) { paused_ = event.paused; }

void SlamRun::take_effect(const Reconfigure& event) {
  LiveConfiguration changed = configuration_.with(event.changes);
  engine_->set_options(changed.setup().engine);
  matcher_ = std::make_shared<TimedMatcher>(changed.setup().matcher);
  engine_->set_matcher(matcher_);
  configuration_ = std::move(changed);
}

/// Whoever runs it leaves the scan out.
void SlamRun::take_effect(const LeaveOut& /*event*/) {}

/// Its place it knows; those that have none yet came before it.
void SlamRun::note_left_out(double stamp, int laser) {
  if (records_ != RunRecords::kAll) {
    return;
  }
  const ScanMoment moment{time_jumps_, stamp, laser};
  for (; timed_events_ < events_.size(); ++timed_events_) {
    events_[timed_events_].scan = moment;
  }
  events_.push_back({moment, LeaveOut{}});
  timed_events_ = events_.size();
}

void SlamRun::step_back() {
  ++time_jumps_;
  has_stepped_back_ = scans_ > 0;  // else nothing has a stamp yet
}

void SlamRun::jump_back() {
  // What was told of the map that is given up would take effect on the next one when repeated.
  const auto is_undone = [](const TimedEvent& event) {
    return !std::holds_alternative<Pause>(event.event) &&
           !std::holds_alternative<Reconfigure>(event.event);
  };
  events_.erase(std::remove_if(events_.begin() + static_cast<std::ptrdiff_t>(timed_events_),
                               events_.end(), is_undone),
                events_.end());
  ++time_jumps_;
  start_with(make_engine());
}

std::vector<TimedEvent> SlamRun::events() const {
  return {events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(timed_events_)};
}

/// The events before a scan get their place by it.
void SlamRun::note_scan(const ScanInput& input) {
  for (; timed_events_ < events_.size(); ++timed_events_) {
    events_[timed_events_].scan = {time_jumps_, input.scan.stamp, input.laser};
  }
}

// --- scans ---

/// Whether the robot is where motion leads to, after a step of the clock.
bool SlamRun::goes_on(const MotionState& before, const ScanInput& input) const {
  // [s] from scan to scan, however slow the laser and however many were needed to tell the step. A
  // guess: half and double were not tried.
  constexpr double kScanInterval = 2.0;
  if (is_told_ || key_scans().empty()) {
    return true;
  }
  if (before.odom_from_base && odometry_of(input)) {
    return does_odometry_go_on(before.odom_from_base, odometry_of(input), kScanInterval);
  }
  return before.stamp.value_or(0.0) - clock_offset() - input.scan.stamp <= kLongestPause;
}

/// With the first scan after a step of the clock. Those of the run go on.
void SlamRun::begin_clock(const ScanInput& input) {
  // So many intervals between scans it took until the step was told: a guess, as the next.
  constexpr double kScans = 3.0;
  constexpr double kMaxInterval = 0.3;  // [s]
  const bool does_go_on = goes_on(engine_->motion(), input);
  const double newest = live_trajectory_.back().stamp;
  const double interval =
      live_trajectory_.size() < 2 ? kMaxInterval : newest - (live_trajectory_.end() - 2)->stamp;
  const double since = newest + kScans * std::min(interval, kMaxInterval);
  clocks_.push_back({since, since - input.scan.stamp});
  if (!does_go_on) {
    begin_drive(input.scan.stamp);
  }
}

std::optional<ScanOutcome> SlamRun::process(const ScanInput& input) {
  note_scan(input);
  if (paused_) {
    return std::nullopt;
  }
  if (has_stepped_back_) {
    begin_clock(input);
    has_stepped_back_ = false;
  }
  if (is_anywhere_) {
    begin_drive(input.scan.stamp);
    is_anywhere_ = false;
  }
  is_told_ = false;
  const double begin = thread_seconds();
  ScanOutcome outcome = process_by_clock(input);
  // The component that a lost robot makes never comes into a map that stays as it is.
  outcome.inserted = outcome.inserted && setup().engine.slam.update_map;

  std::vector<float>& seconds = scan_seconds_[outcome.state];
  seconds.push_back(static_cast<float>(thread_seconds() - begin));
  last_match_seconds_ = matcher_->take_seconds();
  if (last_match_seconds_ > 0.0) {
    match_seconds_.push_back(static_cast<float>(last_match_seconds_));
    evidences_.push_back(static_cast<float>(outcome.evidence.mean));
  }
  if (records_ == RunRecords::kRecent) {
    keep_recent(seconds);
    keep_recent(match_seconds_);
    keep_recent(evidences_);
    keep_recent(trajectory_);
    keep_recent(live_trajectory_);
    keep_recent(odometry_);
  }
  record(outcome);
  robot_beams_[input.laser].add(input.scan, outcome.map_from_base, setup().engine.scan);
  returns_[input.laser].add(input.scan, setup().engine.scan);
  note_lasers();
  return outcome;
}

ScanOutcome SlamRun::process_by_clock(const ScanInput& input) {
  if (clock_offset() == 0.0) {
    return engine_->process(input);
  }
  ScanInput moved = input;
  moved.scan.stamp += clock_offset();
  return engine_->process(moved);
}

std::size_t SlamRun::clock_at(double stamp) const {
  std::size_t clock = clocks_.size() - 1;
  while (stamp < clocks_[clock].since) {
    --clock;
  }
  return clock;
}

std::vector<std::vector<StampedPose2>> SlamRun::by_clock(
    const std::vector<StampedPose2>& poses) const {
  std::vector<std::vector<StampedPose2>> parts(clocks_.size());
  for (const StampedPose2& pose : poses) {
    const std::size_t clock = clock_at(pose.stamp);
    parts[clock].push_back({pose.stamp - clocks_[clock].offset, pose.pose});
  }
  return parts;
}

std::string SlamRun::scan_topic(int laser) const {
  const std::vector<std::string>& topics = setup().run.scan_topics;
  const auto index = static_cast<std::size_t>(laser);
  return index < topics.size() ? topics[index] : fmt::format("number {}", laser);
}

void SlamRun::note_lasers() {
  laser_news_.clear();
  for (const auto& [number, laser] : secondary_lasers()) {
    LaserUse& told = laser_uses_[number];
    const LaserUse use = use_of(laser);
    if (use != told && use != LaserUse::kUnsure) {
      laser_news_.push_back(number);
    }
    told = use;
  }
}

std::vector<double> SlamRun::robot_beams() const {
  std::vector<double> all;
  for (const auto& [laser, beams] : robot_beams_) {
    all.insert(all.end(), beams.sectors().begin(), beams.sectors().end());
  }
  return all;
}

std::optional<std::size_t> SlamRun::returns() const {
  std::optional<std::size_t> most;
  for (const auto& [laser, count] : returns_) {
    most = std::max(most, count.median());
  }
  return most;
}

/// From one component to another the frame may change with any scan that is lost: where nothing was
/// found in between, they are one stretch here.
void SlamRun::note_disconnected(const ScanOutcome& outcome) {
  if (outcome.state != TrackingState::kLost) {
    is_disconnected_ = false;
    return;
  }
  if (!is_disconnected_) {
    disconnected_.emplace_back(outcome.stamp, outcome.stamp);
  }
  disconnected_.back().second = outcome.stamp;
  is_disconnected_ = true;
}

bool SlamRun::is_in_map(double stamp) const {
  return std::none_of(disconnected_.begin(), disconnected_.end(), [stamp](const auto& stretch) {
    return stretch.first <= stamp && stamp <= stretch.second;
  });
}

std::vector<StampedPose2> SlamRun::in_map(const std::vector<StampedPose2>& poses) const {
  std::vector<StampedPose2> inside;
  std::copy_if(poses.begin(), poses.end(), std::back_inserter(inside),
               [this](const StampedPose2& pose) { return is_in_map(pose.stamp); });
  return inside;
}

void SlamRun::correct_by(const std::optional<MapCorrection>& correction) {
  if (correction) {
    correct(*correction, trajectory_);
    path_.change([&](auto& poses) { correct(*correction, poses); });
  }
}

void SlamRun::record(const ScanOutcome& outcome) {
  ++scans_;
  ++statuses_[status_text(outcome)];
  ++certainties_[outcome.certainty];
  ++states_[outcome.state];
  if (outcome.joined) {
    const auto change = [&joined = *outcome.joined](auto& poses) {
      change_frame_since(joined.begin, joined.map_from_component, poses);
    };
    change(trajectory_);
    path_.change(change);
    const bool is_in_map = outcome.state != TrackingState::kLost;  // else in another component
    while (is_in_map && !disconnected_.empty() &&
           disconnected_.back().second >= outcome.joined->begin) {
      disconnected_.pop_back();
    }
  }
  note_disconnected(outcome);
  correct_by(outcome.corrected);
  inserted_ += outcome.inserted ? 1 : 0;
  left_out_ += outcome.left_out;
  components_given_up_ += outcome.gave_up_component ? 1 : 0;
  path_.add({outcome.stamp, outcome.map_from_base});
  if (outcome.odom_from_base) {
    odometry_path_.add({outcome.stamp, *outcome.odom_from_base});
    add_pose({outcome.stamp, *outcome.odom_from_base}, odometry_);
  }
  add_pose({outcome.stamp, outcome.map_from_base}, trajectory_);
  add_pose({outcome.stamp, outcome.map_from_base}, live_trajectory_);
}

}  // namespace matchbox_slam
