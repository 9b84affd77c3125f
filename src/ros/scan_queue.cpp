#include "ros/scan_queue.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <utility>

#include "ros/imu_heading.hpp"
#include "ros/message_conversion.hpp"
#include "run/run_dialog.hpp"

namespace matchbox_slam {

namespace {

// ros::Time throws beyond 2^32 s.
constexpr double kLatestStamp = 4e9;

// Farther from the base no laser is, and no robot gets while one scan is taken. Beyond, a scan
// would be torn over more map than any memory holds.
constexpr double kMostReach = 1000.0;  // m

/// What makes a scan unusable once its transforms are known, for people; empty: nothing.
std::string find_defect(const ScanInput& input) {
  if (const double away = input.base_from_laser.translation().norm(); !(away <= kMostReach)) {
    return fmt::format("its laser is {:f} m from the base; allowed: up to 1000 m", away);
  }
  if (!input.odometry) {
    return {};
  }
  const Pose2 motion =
      input.odometry->odom_from_base.inverse() * input.odometry->odom_from_base_last_beam;
  if (const double moved = motion.translation().norm(); !(moved <= kMostReach)) {
    return fmt::format(
        "the base moves by {:f} m while it is taken, says its odometry; allowed: up to 1000 m",
        moved);
  }
  return {};
}

/// Of the first beam's plane or the last's, whichever is more [rad].
double largest_tilt(const ScanInput& input) {
  return std::max(tilt_of(input.base_from_laser),
                  tilt_of(input.base_from_laser * input.laser_motion));
}

ros::Time last_beam_stamp(const ros::Time& stamp, const LaserScan& scan) {
  return stamp + ros::Duration(scan.duration());
}

}  // namespace

std::string text_of(const TimeJump& jump, std::size_t scans_before) {
  return fmt::format("time jumps back by {} after {} scans: ", seconds_text(jump.seconds),
                     scans_before);
}

ScanQueue::ScanQueue(ScanQueueSettings settings)
    : settings_(std::move(settings)),
      transforms_(static_cast<const RobotFrames&>(settings_)),
      stamps_(settings_.lasers),
      sweep_times_(settings_.timing.sweep_time, settings_.shown_sweeps, settings_.projection,
                   settings_.odom_frame && *settings_.odom_frame != kImuHeadingFrame) {}

void ScanQueue::add_scan(const sensor_msgs::LaserScan& message, const ros::Time& now, int laser) {
  add_scan(to_scan(boost::make_shared<sensor_msgs::LaserScan>(message)), now, laser);
}

void ScanQueue::add_scan(const ScanMessage& message, const ros::Time& now, int laser) {
  const sensor_msgs::LaserScan& scan = *message.scan;
  std::string defect = message.defect.empty() ? find_defect(scan) : message.defect;
  const double stamp = scan.header.stamp.toSec() + settings_.scan_time_offset.toSec();
  if (defect.empty() && !(stamp > 0.0 && stamp < kLatestStamp)) {
    defect = fmt::format("scan_time_offset takes its stamp to {:f} s", stamp);
  }
  advance(now);
  if (!defect.empty()) {
    const bool is_empty = message.defect.empty() ? scan.ranges.empty() : message.is_empty;
    ++account_.received;
    skip(scan.header.stamp, is_empty ? SkipReason::kEmpty : SkipReason::kInvalid, defect);
    return;
  }
  add_joined(message, laser);
  collect_ready(true);
  limit_waiting();
  give_up_late();
}

/// The scan, or the turn that is whole with this part of it; nothing where more parts are to come.
void ScanQueue::add_joined(const ScanMessage& message, int laser) {
  const sensor_msgs::LaserScan& scan = *message.scan;
  Parts& parts =
      parts_.try_emplace(laser, Parts{ScanJoiner(settings_.timing.join_parts)}).first->second;
  parts.stamp = scan.header.stamp;
  parts.frame = without_leading_slash(scan.header.frame_id);
  parts.scan_time = static_cast<double>(scan.scan_time);
  parts.has_times = message.has_times;
  if (parts.joiner.add(to_laser_scan(scan))) {
    account_.received -= waiting_.erase(parts.latest);
  }
  take_joined(parts, laser);
  tell(parts.joiner.take_news());
}

void ScanQueue::take_joined(Parts& parts, int laser) {
  for (LaserScan& scan : parts.joiner.take()) {
    const bool is_latest = scan.stamp == parts.stamp.toSec();  // which tells it without rounding
    const ros::Time stamp = is_latest ? parts.stamp : ros::Time(scan.stamp);
    const double sent_increment = scan.time_increment;
    ++account_.received;
    parts.latest = {stamp + settings_.scan_time_offset, laser};
    add_valid_scan(
        {*now_, parts.frame, std::move(scan), sent_increment, parts.scan_time, parts.has_times},
        parts.latest);
  }
}

/// Of turns whose other parts will not come.
void ScanQueue::skip_parts(SkipReason reason, const std::string& why) {
  for (auto& [laser, parts] : parts_) {
    parts.joiner.finish();
    for (const LaserScan& scan : parts.joiner.take()) {
      ++account_.received;
      skip(ros::Time(scan.stamp) + settings_.scan_time_offset, reason, why);
    }
    parts.joiner.begin_anew();
  }
}

void ScanQueue::add_valid_scan(WaitingScan&& scan, const Turn& turn) {
  const ros::Time& stamp = turn.stamp;
  if (stamps_.is_straggler(stamp, *now_)) {
    skip(stamp, SkipReason::kTimeJump, "it is from before time jumped back");
    return;
  }
  if (stamps_.is_set_back(stamp, turn.laser, last_ready_ ? &last_ready_->stamp : nullptr)) {
    jump_back(seconds_between(stamp, last_ready_->stamp), *now_);
  }
  if (stopped_) {
    skip(stamp, SkipReason::kStopped, "time has jumped back, and time_jump is 'stop'");
  } else if (waiting_.count(turn) != 0 ||
             (last_ready_ && last_ready_->stamp == stamp && last_ready_->laser == turn.laser)) {
    skip(stamp, SkipReason::kDuplicateStamp, "there was a scan of this stamp before");
  } else if (last_ready_ && turn < *last_ready_) {
    skip(stamp, SkipReason::kOutOfOrder, "a later scan was used already");
  } else if (stamps_.leaps_ahead(stamp, *now_)) {
    skip(stamp, SkipReason::kOutOfOrder, "its stamp is far ahead of the scans before it");
    return;  // by it, no other laser would be waited for any more
  } else {
    scan.scan.stamp = stamp.toSec();
    waiting_.emplace(turn, std::move(scan));
  }
  stamps_.note(stamp, turn.laser);
}

void ScanQueue::add_transforms(const tf2_msgs::TFMessage& message, bool is_static,
                               const ros::Time& now) {
  advance(now);
  transforms_.add(message, is_static);
  collect_ready(true);
}

std::string ScanQueue::add_imu(const sensor_msgs::Imu& message, const ros::Time& now) {
  advance(now);
  std::string defect = transforms_.add_imu(message);
  collect_ready(true);
  return defect;
}

std::string ScanQueue::add_odometry(const nav_msgs::Odometry& message, const ros::Time& now) {
  advance(now);
  std::string defect = transforms_.add_odometry(message);
  collect_ready(true);
  return defect;
}

void ScanQueue::advance(const ros::Time& now) {
  if (now_ && seconds_between(now, *now_) > kTimeJump) {
    jump_back(seconds_between(now, *now_), now);
  }
  if (now_ && now_->isZero() && !now.isZero()) {  // simulated time has just begun
    for (auto& [turn, scan] : waiting_) {
      scan.arrival = now;
    }
  }
  now_ = now;
}

void ScanQueue::jump_back(double seconds, const ros::Time& now) {
  for (const auto& [turn, scan] : waiting_) {
    skip(turn.stamp, SkipReason::kTimeJump, "it was waiting when time jumped back");
  }
  waiting_.clear();
  skip_parts(SkipReason::kTimeJump, "its other parts were to come when time jumped back");
  sweep_times_.forget();
  stamps_.jump_back(seconds, now);
  transforms_.clear();
  last_ready_.reset();
  if (!stopped_) {
    stopped_ = settings_.stop_at_time_jump;
    ready_.emplace_back(TimeJump{seconds, stopped_});
  }
}

void ScanQueue::collect_ready(bool wait_for_more) {
  while (!waiting_.empty()) {
    const auto oldest = waiting_.begin();
    const Turn turn = oldest->first;
    if (wait_for_more && !is_its_turn(turn, oldest->second)) {
      return;
    }
    const bool has_times = oldest->second.has_times;
    if (!has_times) {
      choose_sweep_time(turn, oldest->second);
    }
    const BeamStamps beams{turn.stamp, last_beam_stamp(turn.stamp, oldest->second.scan)};
    if (last_ready_ && turn.laser == last_ready_->laser &&
        turn.stamp.toSec() <= last_ready_->stamp.toSec()) {
      skip(turn.stamp, SkipReason::kDuplicateStamp, "there was a scan of this stamp before");
    } else if (const auto missing = transforms_.missing(turn.laser, oldest->second.frame, beams);
               !missing) {
      if (wait_for_more && may_be_part(turn, oldest->second)) {
        place(turn, beams, oldest->second);
        oldest->second.was_kept_back = true;
        return;
      }
      const double sent_increment = oldest->second.sent_increment;
      tell(transforms_.take_overruled(turn.laser, oldest->second.frame, turn.stamp));
      const ScanInput* input = deliver(turn, make_ready(turn, beams, std::move(oldest->second)));
      if (input != nullptr && !has_times) {
        sweep_times_.add(*input, sent_increment);
      }
    } else if (wait_for_more &&
               seconds_between(oldest->second.arrival, *now_) <= settings_.transform_timeout) {
      return;
    } else {
      skip(turn.stamp, SkipReason::kNoTransform, transforms_.why_missing(*missing));
    }
    waiting_.erase(oldest);
  }
}

/// By the scans that were delivered before it, so that it is the same in every replay.
void ScanQueue::choose_sweep_time(const Turn& turn, WaitingScan& waiting) {
  if (sweep_times_.has_odometry()) {
    const auto odom_from_base_at = [&](double stamp) {
      return transforms_.odom_from_base(ros::Time(stamp));
    };
    // Where it is not there yet, the scan has to wait, and comes here again.
    if (const std::optional<Pose2> pose = transforms_.odom_from_base(turn.stamp)) {
      sweep_times_.note_pose(turn.laser, waiting.scan.stamp, *pose, odom_from_base_at);
    }
  }
  waiting.scan.time_increment = waiting.sent_increment;
  waiting.scan.time_increment =
      sweep_times_.time_increment(turn.laser, waiting.scan, waiting.sent_scan_time);
  tell(sweep_times_.take_news(turn.laser));
}

/// The scan as it was delivered; null: it was skipped.
const ScanInput* ScanQueue::deliver(const Turn& turn, ReadyScan&& scan) {
  if (transforms_.are_frames_swapped()) {
    skip(scan.stamp, SkipReason::kNoTransform,
         text_of_swapped_frames(settings_.base_frame, *settings_.odom_frame));
    return nullptr;
  }
  if (const std::string defect = find_defect(scan.input); !defect.empty()) {
    skip(scan.stamp, SkipReason::kInvalid, defect);
    return nullptr;
  }
  if (const double tilt = largest_tilt(scan.input); tilt > settings_.projection.max_tilt) {
    skip(scan.stamp, SkipReason::kTilted,
         fmt::format("its plane is tilted by {:.3f} rad; scan/max_tilt allows {:.3f}", tilt,
                     settings_.projection.max_tilt));
    return nullptr;
  }
  last_ready_ = turn;
  ready_.emplace_back(std::move(scan));
  ++ready_scans_;
  return &std::get<ReadyScan>(ready_.back()).input;
}

/// Whether no other laser is likely to send an earlier scan.
bool ScanQueue::is_its_turn(const Turn& turn, const WaitingScan& scan) const {
  return seconds_between(scan.arrival, *now_) > kPatienceWithLasers || stamps_.is_next(turn.stamp);
}

/// Whether the next scan of its laser may yet tell that it is a part of a turn.
bool ScanQueue::may_be_part(const Turn& turn, const WaitingScan& scan) const {
  return parts_.at(turn.laser).joiner.is_undecided() &&
         seconds_between(scan.arrival, *now_) <= kPatienceWithLasers;
}

std::deque<ScanQueue::Item>::const_iterator ScanQueue::oldest_ready_scan() const {
  return std::find_if(ready_.begin(), ready_.end(),
                      [](const Item& item) { return std::holds_alternative<ReadyScan>(item); });
}

void ScanQueue::drop_oldest_ready(SkipReason reason, const std::string& why) {
  const auto oldest = oldest_ready_scan();
  skip(std::get<ReadyScan>(*oldest).stamp, reason, why);
  ready_.erase(oldest);
  --ready_scans_;
}

/// As a repetition has to leave it out, too, something stays in its place.
void ScanQueue::leave_out_oldest_ready(SkipReason reason, const std::string& why) {
  const auto oldest = ready_.begin() + (oldest_ready_scan() - ready_.cbegin());
  const auto& scan = std::get<ReadyScan>(*oldest);
  const LeftOut left_out{scan.input.scan.stamp, scan.input.laser};
  skip(scan.stamp, reason, why);
  *oldest = left_out;
  --ready_scans_;
}

void ScanQueue::drop_all_ready(SkipReason reason, const std::string& why) {
  while (ready_scans_ > 0) {
    drop_oldest_ready(reason, why);
  }
}

/// Whoever is too slow is served best with what is newest: that one always stays.
void ScanQueue::give_up_late() {
  if (settings_.max_lag <= 0.0) {
    return;
  }
  while (ready_scans_ > 1) {
    const double lag = seconds_between(std::get<ReadyScan>(*oldest_ready_scan()).arrival, *now_);
    if (lag <= settings_.max_lag) {
      return;
    }
    leave_out_oldest_ready(
        SkipReason::kTooLate,
        fmt::format("it would be processed {:f} s after it came, and max_lag is {:f}", lag,
                    settings_.max_lag));
  }
}

void ScanQueue::limit_waiting() {
  const std::string text =
      fmt::format("more than {} scans wait to be processed", settings_.max_waiting);
  while (waiting() > settings_.max_waiting && ready_scans_ > 0) {
    leave_out_oldest_ready(SkipReason::kQueueFull, text);
  }
  while (waiting() > settings_.max_waiting) {
    skip(waiting_.begin()->first.stamp, SkipReason::kQueueFull, text);
    waiting_.erase(waiting_.begin());
  }
}

std::optional<ScanQueue::Item> ScanQueue::next() {
  if (ready_.empty()) {
    return std::nullopt;
  }
  Item item = std::move(ready_.front());
  ready_.pop_front();
  if (std::holds_alternative<ReadyScan>(item)) {
    --ready_scans_;
    ++account_.delivered;
  }
  return item;
}

void ScanQueue::add_event(RunEvent event) {
  if (gives_up_map(event)) {
    drop_all_ready(SkipReason::kBeforeReset, "it was waiting when its map was given up");
  }
  ready_.emplace_back(std::move(event));
}

void ScanQueue::leave_out(const ReadyScan& scan, SkipReason reason, const std::string& why) {
  --account_.delivered;
  skip(scan.stamp, reason, why);
}

void ScanQueue::discard_delivered() {
  if (account_.delivered > 0) {
    account_.skipped[SkipReason::kBeforeReset] += std::exchange(account_.delivered, 0);
  }
}

void ScanQueue::finish() {
  for (auto& [laser, parts] : parts_) {
    parts.joiner.finish();
    take_joined(parts, laser);
  }
  collect_ready(false);
}

void ScanQueue::interrupt() {
  const std::string why = "it was waiting when the run was ended";
  drop_all_ready(SkipReason::kInterrupted, why);
  skip_parts(SkipReason::kInterrupted, why);
  for (const auto& [turn, scan] : waiting_) {
    skip(turn.stamp, SkipReason::kInterrupted, why);
  }
  waiting_.clear();
  ready_.clear();
}

void ScanQueue::tell(std::string news) {
  if (!news.empty()) {
    news_.push_back(std::move(news));
  }
}

std::vector<SkippedScan> ScanQueue::take_skipped() { return std::exchange(skipped_, {}); }

void ScanQueue::skip(const ros::Time& stamp, SkipReason reason, const std::string& why) {
  ++account_.skipped[reason];
  skipped_.push_back(
      {stamp, reason,
       fmt::format("scan of {:.3f} s skipped ({}): {}", stamp.toSec(), to_string(reason), why)});
}

/// Once, as soon as that can be told: what tf says of a moment changes by a rounding when more
/// comes.
void ScanQueue::place(const Turn& turn, const BeamStamps& beams, WaitingScan& scan) const {
  if (!scan.placed) {
    scan.placed = transforms_.place(turn.laser, scan.frame, beams);
  }
}

ReadyScan ScanQueue::make_ready(const Turn& turn, const BeamStamps& beams,
                                WaitingScan&& scan) const {
  place(turn, beams, scan);
  PlacedLaser& placed = *scan.placed;
  ReadyScan ready;
  ready.stamp = turn.stamp;
  ready.arrival = scan.was_kept_back ? *now_ : scan.arrival;  // it is not late for that
  ready.frame = std::move(scan.frame);
  ready.is_odometry_in_tf = placed.is_odometry_in_tf;
  ready.input = {std::move(scan.scan), placed.base_from_laser, placed.odometry, turn.laser,
                 placed.laser_motion};
  return ready;
}

}  // namespace matchbox_slam
