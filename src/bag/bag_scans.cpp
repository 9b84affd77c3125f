#include "bag/bag_scans.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "bag/queued_message.hpp"
#include "bag/sweep_survey.hpp"
#include "common/interrupted.hpp"
#include "ros/message_conversion.hpp"
#include "ros/queue_settings.hpp"
#include "run/frames.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMessagesAhead = 512;  // messages

std::optional<std::string> given(const Parameters& parameters, const std::string& name,
                                 const std::string& value) {
  return parameters.find(name) != nullptr ? std::optional(value) : std::nullopt;
}

/// The frames that were asked for, which must differ before the bag can tell about the others.
void check_asked_frames(const Parameters& parameters, RunOptions options) {
  options.base_frame = given(parameters, "base_frame", options.base_frame).value_or("");
  options.odom_frame = given(parameters, "odom_frame", options.odom_frame).value_or("");
  check_frames(options);
}

}  // namespace

Parameters frame_parameters(const BagRequest& request) {
  Parameters parameters;
  if (request.base_frame) {
    parameters.set("base_frame", *request.base_frame);
  }
  if (request.odom_frame) {
    parameters.set("odom_frame", *request.odom_frame);
  }
  if (request.no_odometry) {
    parameters.set("use_odometry", false);
  }
  if (request.odom_topic) {
    parameters.set("odom_topic", *request.odom_topic);
  }
  if (!request.laser_poses.empty()) {
    parameters.set("laser_pose", join(request.laser_poses));
  }
  return parameters;
}

BagScans::BagScans(const BagRequest& request, const RunDialog& dialog)
    : request_(request), dialog_(dialog), reader_(request.bags) {
  facts_.bags = request.bags;
  facts_.threads = request.threads;
}

/// As choose_motion; what is missing may be in the part that cannot be read.
BagMotion BagScans::motion_before_damage(const BagSurvey& survey, const AskedFrames& asked,
                                         const RunOptions& options) const {
  try {
    return choose_motion(reader_, survey, asked, request_.period, options);
  } catch (const ConfigurationError& error) {
    if (survey.damage.empty()) {
      throw;
    }
    throw BagError(fmt::format("{}; of the part before: {}", survey.damage, error.what()));
  }
}

RunOptions BagScans::prepare(const Parameters& parameters, RunOptions options) {
  check_asked_frames(parameters, options);
  for (const std::string& remark : reader_.remarks()) {
    dialog_.warn(remark);
  }
  facts_.scan_topics = choose_scan_topics(
      reader_, request_.scan_topics.empty() ? options.scan_topics : request_.scan_topics);
  if (const std::string mixed = reader_.text_of_overlap(facts_.scan_topics); !mixed.empty()) {
    dialog_.warn(mixed);
  }
  const CloudOptions cloud = read_cloud_options(parameters);
  const BagSurvey survey =
      survey_bag(reader_, facts_.scan_topics, request_.period, options.map_frame,
                 dialog_.is_interrupted, cloud, !options.laser_pose.empty());
  require_not_interrupted();
  if (survey.scan_frame.empty()) {
    throw BagError(
        fmt::format("the bag holds no scan on topic {} in the period asked for; it lasts {}",
                    join(facts_.scan_topics),
                    seconds_text(seconds_between(reader_.begin_time(), reader_.end_time()))));
  }
  const BagMotion motion = motion_before_damage(
      survey,
      {given(parameters, "base_frame", options.base_frame),
       given(parameters, "odom_frame", options.odom_frame), !options.laser_pose.empty()},
      options);
  options.base_frame = motion.frames.base;
  options.odom_frame = motion.frames.odom.value_or("");
  options.use_odometry = motion.frames.odom.has_value();
  options.odom_topic = motion.odom_topic;
  options.imu_topic = motion.imu_topic;
  check_frames(options);
  dialog_.inform(fmt::format("{}{}; scan frame {}; base frame {}{}",
                             facts_.scan_topics.size() > 1 ? "scan topics " : "scan topic ",
                             text_of_topics(), survey.scan_frame, motion.frames.base, motion.told));
  choose_clock(survey, options);
  facts_.no_return_from =
      find_no_returns(reader_, facts_.scan_topics, dialog_.is_interrupted, cloud);
  require_not_interrupted();
  options.scan_topics = facts_.scan_topics;
  ScanQueueSettings settings =
      queue_settings(options, read_projection_options(parameters),
                     read_scan_timing_options(parameters), facts_.scan_time_offset);
  settings.is_live = false;
  settings.shown_sweeps = shown_sweeps(settings, options, cloud);
  queue_.emplace(std::move(settings));
  stream_ = reader_.stream(facts_.scan_topics, request_.period, options.imu_topic, cloud,
                           options.odom_topic);
  if (request_.threads > 1) {
    stream_ = read_ahead(std::move(stream_), kMessagesAhead);
  }
  return options;
}

/// [s] by laser, where they have to be found out.
std::map<int, double> BagScans::shown_sweeps(const ScanQueueSettings& settings,
                                             const RunOptions& options,
                                             const CloudOptions& cloud) const {
  const SweepTimeSetting& asked = settings.timing.sweep_time;
  if (request_.is_repetition || asked.as_sent || asked.seconds) {
    return {};
  }
  const std::map<int, ShownSweep> all =
      survey_sweeps(reader_, settings, facts_.scan_topics, options.imu_topic, cloud,
                    options.odom_topic, dialog_.is_interrupted);
  require_not_interrupted();
  std::map<int, double> sweeps;
  for (const auto& [laser, shown] : all) {
    sweeps.emplace(laser, shown.seconds);
    if (!shown.text.empty()) {
      const std::string& topic = facts_.scan_topics.at(static_cast<std::size_t>(laser));
      dialog_.warn(facts_.scan_topics.size() > 1 ? fmt::format("{}: {}", topic, shown.text)
                                                 : shown.text);
    }
  }
  return sweeps;
}

/// With what they hold where it is not laser scans as such.
std::string BagScans::text_of_topics() const {
  std::vector<std::string> texts;
  for (const std::string& topic : facts_.scan_topics) {
    const std::string type = reader_.type_of(topic);
    texts.push_back(topic + (type == scan_types().front() ? "" : fmt::format(" ({})", type)));
  }
  return join(texts);
}

void BagScans::choose_clock(const BagSurvey& survey, const RunOptions& options) {
  facts_.estimated_clock_offset = survey.scan_time_offset;
  const double estimate = survey.scan_time_offset.value_or(0.0);
  const bool differs = std::abs(estimate) > kMinToldClockOffset;
  const std::optional<double> fixed = fixed_scan_time_offset(options);
  facts_.scan_time_offset = fixed.value_or(differs ? estimate : 0.0);
  if (differs && std::abs(estimate - facts_.scan_time_offset) > kMinToldClockOffset) {
    dialog_.warn(
        fmt::format("the clocks of scans and tf differ: scans are {}{}; to correct that give --set "
                    "scan_time_offset=auto",
                    seconds_text(std::abs(estimate)), estimate > 0.0 ? " behind" : " ahead"));
  } else if (facts_.scan_time_offset != 0.0) {
    dialog_.inform(fmt::format("stamps of scans are moved by {:.3f} s to the clock of tf",
                               facts_.scan_time_offset));
  }
}

std::optional<ScanQueue::Item> BagScans::next() {
  while (true) {
    if (!facts_.interrupted && dialog_.is_interrupted()) {
      facts_.interrupted = true;
      queue_->interrupt();
      stop();
    }
    if (const ScanQueue::Item* next = queue_->peek()) {
      if (is_event_due(*next)) {
        const TimedEvent event = std::move(events_.front());
        events_.pop_front();
        if (std::holds_alternative<LeaveOut>(event.event)) {
          leave_out_next(event.scan);
          continue;
        }
        return event.event;
      }
      const auto* jump = std::get_if<TimeJump>(next);
      const bool is_end = jump != nullptr && jump->stopped;
      if (jump != nullptr) {
        ++time_jumps_;
        first_skip_.clear();
        used_before_jump_ += queue_->account().delivered;
      }
      if (const auto* scan = std::get_if<ReadyScan>(next)) {
        delivered_time_ = std::max(delivered_time_, scan->arrival);
      }
      std::optional<ScanQueue::Item> item = queue_->next();
      if (is_end) {
        stop();
      }
      return item;
    }
    if (stream_ == nullptr) {
      return std::nullopt;
    }
    read_message();
  }
}

void BagScans::schedule(std::vector<TimedEvent> events) {
  events_.assign(std::make_move_iterator(events.begin()), std::make_move_iterator(events.end()));
}

/// Where the next scan is the one of that moment; else it is not there to be left out.
void BagScans::leave_out_next(const ScanMoment& moment) {
  const auto& next = std::get<ReadyScan>(*queue_->peek());
  if (!(moment < ScanMoment{time_jumps_, next.input.scan.stamp, next.input.laser})) {
    const auto item = queue_->next();
    queue_->leave_out(std::get<ReadyScan>(*item), SkipReason::kTooLate,
                      "the node had no time for it, as the file of events says");
  }
}

bool BagScans::is_event_due(const ScanQueue::Item& next) const {
  const auto* scan = std::get_if<ReadyScan>(&next);
  return scan != nullptr && !events_.empty() &&
         !(ScanMoment{time_jumps_, scan->input.scan.stamp, scan->input.laser} <
           events_.front().scan);
}

BagPeriod BagScans::rest() const {
  constexpr double kStep = 1e-3;  // [s], so that it is short to type
  const double delivered = seconds_between(reader_.begin_time(), delivered_time_);
  const double start = std::floor(delivered / kStep + 1.5) * kStep;
  const BagPeriod& asked = request_.period;
  // Rounded up, so that the last scan is in it.
  const double left = std::ceil((asked.start + asked.duration - start) / kStep) * kStep;
  return {start, std::max(0.0, left)};
}

void BagScans::read_message() {
  std::optional<BagMessage> message;
  try {
    message = stream_->next();
  } catch (const BagError& error) {
    facts_.damage = error.what();
  }
  if (message) {
    take(*message);
    warn_of_skipped();
  } else {
    stop();
  }
}

void BagScans::take(const BagMessage& message) {
  const std::string defect = add_message(message, *queue_);
  if (std::holds_alternative<BagTransforms>(message.content)) {
    warn_of_map_link();
    return;
  }
  if (!std::holds_alternative<ScanMessage>(message.content)) {
    const bool is_imu = std::holds_alternative<sensor_msgs::Imu::ConstPtr>(message.content);
    warn_of_ignored(is_imu ? "the IMU" : "the odometry", defect);
    return;
  }
  first_time_ = first_time_ ? first_time_ : message.time;
  facts_.seconds = seconds_between(*first_time_, message.time);
  show_progress(message.time);
}

void BagScans::stop() {
  stream_.reset();
  queue_->finish();
  warn_of_skipped();
  facts_.ignored_map_link = queue_->transforms().ignored_map_link();
  facts_.invalid_transforms = queue_->transforms().invalid_count();
  facts_.invalid_odometry = queue_->invalid_odometry();
}

void BagScans::warn_of_skipped() {
  for (const std::string& news : queue_->take_news()) {
    dialog_.warn(news);
  }
  for (const SkippedScan& skipped : queue_->take_skipped()) {
    if (told_.insert(skipped.reason).second) {
      dialog_.warn(skipped.text);
    }
    if (first_skip_.empty()) {
      first_skip_ = skipped.text;
    }
  }
}

void BagScans::warn_of_map_link() {
  const std::string& link = queue_->transforms().ignored_map_link();
  if (!told_of_map_link_ && !link.empty()) {
    dialog_.warn("tf in the bag that touches the map frame is ignored: " + link);
    told_of_map_link_ = true;
  }
}

void BagScans::warn_of_ignored(const std::string& whose, const std::string& defect) {
  if (!defect.empty() && told_of_ignored_.insert(whose).second) {
    dialog_.warn(fmt::format("messages of {} are ignored; the first: {}", whose, defect));
  }
}

void BagScans::show_progress(const ros::Time& time) {
  const double begin = (*first_time_).toSec();
  const double length = std::min(reader_.end_time().toSec() - begin, request_.period.duration);
  const double done = time.toSec() - begin;
  dialog_.show_progress(length > 0.0 ? std::min(done / length, 1.0) : 1.0,
                        fmt::format("{} scans", queue_->account().received));
}

void BagScans::require_not_interrupted() const {
  if (dialog_.is_interrupted()) {
    throw Interrupted("interrupted before the first scan was used; nothing is written");
  }
}

void BagScans::throw_nothing_used() const {
  require_not_interrupted();
  const std::string first = first_skip_.empty() ? "none was read" : first_skip_;
  const std::string damage = facts_.damage.empty() ? "" : "; " + facts_.damage;
  const std::size_t received = queue_->account().received;
  if (used_before_jump_ > 0) {
    throw BagError(
        fmt::format("of {} scans {} were used before time jumped back and none since, the first: "
                    "{}; to map the part before give --set time_jump=stop{}",
                    received, used_before_jump_, first, damage));
  }
  throw BagError(
      fmt::format("none of {} scans could be used; the first: {}{}", received, first, damage));
}

}  // namespace matchbox_slam
