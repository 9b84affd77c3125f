#include "bag/carmen_log.hpp"

#include <fmt/core.h>
#include <ros/message_traits.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "bag/bag_error.hpp"
#include "bag/carmen_line.hpp"
#include "bag/carmen_stamps.hpp"
#include "bag/log_lines.hpp"

namespace matchbox_slam {
namespace {

constexpr const char* kOdometryFrame = "odom";
constexpr const char* kBaseFrame = "base_link";
constexpr double kRangeMin = 0.02;        // [m] nearer readings are none
constexpr double kLatest = 4294967295.0;  // [s] that fits into a stamp of ROS

/// A scan or an odometry of the log.
struct LogEvent {
  std::size_t number = 0;  ///< of its line
  CarmenLine line;
};

/// All that a log tells, line by line.
struct LogText {
  std::vector<LogEvent> events;
  std::map<std::string, double> parameters;
  std::size_t bad_lines = 0;
  std::string first_bad;  ///< which it is and what is wrong
  std::string damage;
};

const CarmenScan* scan_of(const LogEvent& event) {
  return std::get_if<CarmenScan>(&event.line.content);
}

void add_line(const LogLines& lines, const std::string& text, bool& has_logger_stamps,
              LogText& log) {
  try {
    CarmenLine line = parse_carmen_line(text);
    if (const auto* parameter = std::get_if<CarmenParameter>(&line.content)) {
      log.parameters[parameter->name] = parameter->value;
    } else if (!std::holds_alternative<std::monostate>(line.content)) {
      if (has_logger_stamps && !line.logger_stamp && !lines.has_end()) {
        throw CarmenLineError("the file ends within it");
      }
      has_logger_stamps = line.logger_stamp.has_value();
      log.events.push_back({lines.number(), std::move(line)});
    }
  } catch (const CarmenLineError& error) {
    ++log.bad_lines;
    if (log.first_bad.empty()) {
      log.first_bad = fmt::format("line {}: {}", lines.number(), error.what());
    }
  }
}

LogText read_log(const std::string& path) {
  LogText log;
  LogLines lines(path);
  bool has_logger_stamps = false;
  for (std::string text; lines.next(text);) {
    add_line(lines, text, has_logger_stamps, log);
  }
  log.damage = lines.damage();
  return log;
}

/// Which laser messages there are, and how many of each.
std::map<std::string, std::size_t> count_scans(const LogText& log) {
  std::map<std::string, std::size_t> counts;
  for (const LogEvent& event : log.events) {
    if (const CarmenScan* scan = scan_of(event)) {
      ++counts[scan->message];
    }
  }
  return counts;
}

/// A RAWLASER with the number of a ROBOTLASER is the same again without the robot's pose.
std::vector<std::string> remove_repeated(LogText& log) {
  std::vector<std::string> removed;
  const std::map<std::string, std::size_t> counts = count_scans(log);
  for (const auto& [message, count] : counts) {
    const std::string raw = "RAW" + message.substr(std::min<std::size_t>(message.size(), 5));
    if (message.rfind("ROBOTLASER", 0) == 0 && counts.count(raw) > 0) {
      removed.push_back(
          fmt::format("{} is left aside, as {} tells the same and the pose", raw, message));
      log.events.erase(std::remove_if(log.events.begin(), log.events.end(),
                                      [&raw = raw](const LogEvent& event) {
                                        const CarmenScan* scan = scan_of(event);
                                        return scan != nullptr && scan->message == raw;
                                      }),
                       log.events.end());
    }
  }
  return removed;
}

/// FLASER and RLASER do not tell their angles: where another message of so many beams does, they
/// are those.
void take_angles_that_are_told(LogText& log) {
  std::map<std::size_t, std::pair<double, double>> angles;
  for (const LogEvent& event : log.events) {
    const CarmenScan* scan = scan_of(event);
    if (scan != nullptr && scan->tells_angles) {
      angles.emplace(scan->ranges.size(), std::pair(scan->start_angle, scan->increment));
    }
  }
  for (LogEvent& event : log.events) {
    auto* scan = std::get_if<CarmenScan>(&event.line.content);
    if (scan != nullptr && !scan->tells_angles) {
      const auto told = angles.find(scan->ranges.size());
      if (told != angles.end()) {
        std::tie(scan->start_angle, scan->increment) = told->second;
      }
    }
  }
}

std::vector<CarmenMoment> moments_of(const LogText& log) {
  const std::map<std::string, std::size_t> counts = count_scans(log);
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<CarmenMoment> moments;
  moments.reserve(log.events.size());
  for (const LogEvent& event : log.events) {
    const CarmenScan* scan = scan_of(event);
    moments.push_back({event.number, scan != nullptr && scan->message == most->first,
                       event.line.ipc_stamp, event.line.logger_stamp});
  }
  return moments;
}

/// When events were recorded, by a clock that nobody sets back: what comes after such a step of
/// the log's own goes on right after what was before it.
std::vector<double> recorded_times(const std::vector<double>& stamps,
                                   const std::vector<std::size_t>& steps) {
  std::vector<double> times;
  times.reserve(stamps.size());
  double ahead = 0.0;
  double latest = 0.0;
  auto step = steps.begin();
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    if (step != steps.end() && *step == k) {
      const std::size_t end = ++step != steps.end() ? *step : stamps.size();
      const auto first = stamps.begin() + static_cast<std::ptrdiff_t>(k);
      const auto last = stamps.begin() + static_cast<std::ptrdiff_t>(end);
      ahead = latest - *std::min_element(first, last);
    }
    times.push_back(std::min(stamps[k] + ahead, kLatest));
    latest = std::max(latest, times.back());
  }
  return times;
}

/// Where a laser is on the robot.
struct Mount {
  Pose2 base_from_laser;
  std::string remark;
};

bool is_near(const Pose2& a, const Pose2& b) {
  constexpr double kMetres = 0.02;
  constexpr double kRadians = 0.02;
  const Eigen::Vector3d by = difference(a, b);
  return by.head<2>().norm() <= kMetres && std::abs(by.z()) <= kRadians;
}

/// By the poses of laser and robot, where nearly all say the same.
std::optional<Pose2> mount_by_poses(const LogText& log, const std::string& message) {
  constexpr double kMinAgreeingShare = 0.9;
  std::optional<Pose2> first;
  std::size_t poses = 0;
  std::size_t near = 0;
  for (const LogEvent& event : log.events) {
    const CarmenScan* scan = scan_of(event);
    if (scan != nullptr && scan->message == message && scan->laser && scan->robot) {
      const Pose2 mount = scan->robot->inverse() * *scan->laser;
      first = first ? first : mount;
      ++poses;
      near += is_near(mount, *first) ? 1 : 0;
    }
  }
  return static_cast<double>(near) >= kMinAgreeingShare * static_cast<double>(poses) ? first
                                                                                     : std::nullopt;
}

/// By the log's parameters; none: it has none of this laser.
std::optional<Pose2> mount_by_parameters(const LogText& log, const std::string& side) {
  const auto find = [&](const std::string& name) {
    const auto at = log.parameters.find(fmt::format("robot_{}laser_{}", side, name));
    return at != log.parameters.end() ? std::optional(at->second) : std::nullopt;
  };
  const std::optional<double> x = find("offset");
  const std::optional<double> y = find("side_offset");
  const std::optional<double> yaw = find("angular_offset");
  if (side.empty() || !(x || y || yaw)) {
    return std::nullopt;
  }
  const double usual_yaw = side == "rear" ? kPi : 0.0;
  return Pose2{x.value_or(0.0), y.value_or(0.0), wrap_angle(yaw.value_or(usual_yaw))};
}

/// Which of CARMEN's two lasers it is; empty: neither.
std::string side_of(const std::string& message) {
  if (message == "FLASER" || message.back() == '1') {
    return "front";
  }
  return message == "RLASER" || message.back() == '2' ? "rear" : "";
}

Mount mount_of(const LogText& log, const std::string& message) {
  const std::string side = side_of(message);
  const Pose2 usual{0.0, 0.0, side == "rear" ? wrap_angle(kPi) : 0.0};
  const bool has_poses = std::any_of(log.events.begin(), log.events.end(), [&](const auto& event) {
    const CarmenScan* scan = scan_of(event);
    return scan != nullptr && scan->message == message && scan->laser.has_value();
  });
  const std::optional<Pose2> by_poses = mount_by_poses(log, message);
  const std::optional<Pose2> by_parameters = mount_by_parameters(log, side);
  // Many logs write the robot's pose for the laser's.
  const bool poses_tell = by_poses && !is_near(*by_poses, {});
  if (by_parameters) {
    const bool is_told_twice = poses_tell && !is_near(*by_poses, *by_parameters);
    return {*by_parameters, is_told_twice
                                ? message +
                                      " has poses that place the laser elsewhere on the robot than "
                                      "the log's PARAM lines, which are taken"
                                : ""};
  }
  if (poses_tell) {
    return {*by_poses, ""};
  }
  return {usual, has_poses && !by_poses
                     ? message +
                           " has poses of the laser that are not where it is on the robot, "
                           "such as corrected ones, and no PARAM line tells; it is taken to "
                           "be at the robot's middle"
                     : ""};
}

/// Whether the poses that come with scans are others than those of ODOM lines around them.
bool odometry_disagrees(const LogText& log) {
  constexpr double kMaxDistance = 1.0;   // [m]
  constexpr std::size_t kMinScans = 10;  // scans
  std::size_t scans = 0;
  std::size_t far = 0;
  const Pose2* last = nullptr;
  for (const LogEvent& event : log.events) {
    if (const auto* odometry = std::get_if<CarmenOdometry>(&event.line.content)) {
      last = &odometry->robot;
      continue;
    }
    const CarmenScan& scan = *scan_of(event);
    if (last != nullptr && scan.robot) {
      ++scans;
      far += (scan.robot->translation() - last->translation()).norm() > kMaxDistance ? 1 : 0;
      last = nullptr;
    }
  }
  return scans >= kMinScans && 2 * far > scans;
}

std::string in_small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return text;
}

geometry_msgs::TransformStamped to_transform(const ros::Time& stamp, const std::string& parent,
                                             const std::string& child, const Pose2& pose) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = stamp;
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform.translation.x = pose.x;
  transform.transform.translation.y = pose.y;
  transform.transform.rotation.z = std::sin(0.5 * pose.theta);
  transform.transform.rotation.w = std::cos(0.5 * pose.theta);
  return transform;
}

MessageContent odometry_message(const ros::Time& stamp, const Pose2& robot) {
  auto message = boost::make_shared<tf2_msgs::TFMessage>();
  message->transforms = {to_transform(stamp, kOdometryFrame, kBaseFrame, robot)};
  return tf2_msgs::TFMessage::ConstPtr(message);
}

MessageContent scan_message(const ros::Time& stamp, CarmenScan&& scan) {
  auto message = boost::make_shared<sensor_msgs::LaserScan>();
  message->header.stamp = stamp;
  message->header.frame_id = in_small_letters(scan.message);
  const double last = scan.ranges.empty() ? 0.0 : static_cast<double>(scan.ranges.size() - 1);
  message->angle_min = static_cast<float>(scan.start_angle);
  message->angle_max = static_cast<float>(scan.start_angle + scan.increment * last);
  message->angle_increment = static_cast<float>(scan.increment);
  message->range_min = static_cast<float>(kRangeMin);
  message->range_max = static_cast<float>(scan.maximum_range);
  message->ranges = std::move(scan.ranges);
  message->intensities = std::move(scan.remissions);
  return sensor_msgs::LaserScan::ConstPtr(message);
}

/// Turns lines into messages.
class MessageMaker {
 public:
  MessageMaker(const std::string& path, std::map<std::uint32_t, BagConnection>& connections,
               std::vector<CarmenLog::Entry>& entries)
      : path_(path), connections_(connections), entries_(entries) {}

  std::vector<std::string> make(LogText log);

 private:
  void remark(const std::string& text) { remarks_.push_back(fmt::format("'{}': {}", path_, text)); }

  template <typename Message>
  std::uint32_t connection_of(const std::string& topic) {
    const auto [at, is_new] =
        numbers_.emplace(topic, static_cast<std::uint32_t>(connections_.size()));
    if (is_new) {
      connections_[at->second] = {topic, ros::message_traits::datatype<Message>(),
                                  ros::message_traits::md5sum<Message>()};
    }
    return at->second;
  }

  void add(const ros::Time& time, std::uint32_t connection, MessageContent content) {
    ++connections_[connection].messages;
    entries_.push_back({time, connection, std::move(content)});
  }

  void add_mounts(const LogText& log, const ros::Time& begin);
  void remark_on_steps(const LogText& log, const std::vector<double>& stamps,
                       const std::vector<std::size_t>& steps);
  void add_events(LogText log, const std::vector<double>& stamps, const std::vector<double>& times);

  const std::string& path_;
  std::map<std::uint32_t, BagConnection>& connections_;
  std::vector<CarmenLog::Entry>& entries_;
  std::map<std::string, std::uint32_t> numbers_;
  std::vector<std::string> remarks_;
};

void MessageMaker::add_mounts(const LogText& log, const ros::Time& begin) {
  auto message = boost::make_shared<tf2_msgs::TFMessage>();
  for (const auto& [name, count] : count_scans(log)) {
    const Mount mount = mount_of(log, name);
    message->transforms.push_back(
        to_transform(begin, kBaseFrame, in_small_letters(name), mount.base_from_laser));
    if (!mount.remark.empty()) {
      remark(mount.remark);
    }
  }
  add(begin, connection_of<tf2_msgs::TFMessage>("/tf_static"),
      tf2_msgs::TFMessage::ConstPtr(message));
}

void MessageMaker::remark_on_steps(const LogText& log, const std::vector<double>& stamps,
                                   const std::vector<std::size_t>& steps) {
  for (const std::size_t step : steps) {
    remark(fmt::format(
        "at line {} its clock was set back by {:.1f} s; what follows is read after what was before",
        log.events[step].number, stamps[step - 1] - stamps[step]));
  }
}

void MessageMaker::add_events(LogText log, const std::vector<double>& stamps,
                              const std::vector<double>& times) {
  const bool scans_alone = odometry_disagrees(log);
  if (scans_alone) {
    remark(
        "the robot's poses on ODOM lines are others than those that come with its scans; the "
        "latter alone are taken");
  }
  for (std::size_t k = 0; k < log.events.size(); ++k) {
    const ros::Time stamp = std::max(ros::TIME_MIN, ros::Time().fromSec(stamps[k]));
    const ros::Time time = std::max(ros::TIME_MIN, ros::Time().fromSec(times[k]));
    auto* scan = std::get_if<CarmenScan>(&log.events[k].line.content);
    if (scan == nullptr) {
      if (!scans_alone) {
        add(time, connection_of<tf2_msgs::TFMessage>("/tf"),
            odometry_message(stamp, std::get<CarmenOdometry>(log.events[k].line.content).robot));
      }
      continue;
    }
    if (scan->robot) {
      add(time, connection_of<tf2_msgs::TFMessage>("/tf"), odometry_message(stamp, *scan->robot));
    }
    const std::string topic = "/" + in_small_letters(scan->message);
    add(time, connection_of<sensor_msgs::LaserScan>(topic), scan_message(stamp, std::move(*scan)));
  }
}

std::vector<std::string> MessageMaker::make(LogText log) {
  if (log.bad_lines > 0) {
    remark(fmt::format("{}{} left out; {}{}", log.bad_lines,
                       log.bad_lines == 1 ? " line is" : " lines, among them perhaps scans, are",
                       log.bad_lines == 1 ? "" : "the first, ", log.first_bad));
  }
  for (const std::string& removed : remove_repeated(log)) {
    remark(removed);
  }
  if (count_scans(log).empty()) {
    return remarks_;
  }
  take_angles_that_are_told(log);
  const std::vector<CarmenMoment> moments = moments_of(log);
  const CarmenStamps chosen = choose_stamps(moments);
  if (!chosen.remark.empty()) {
    remark(chosen.remark);
  }
  const std::vector<std::size_t> steps = find_clock_steps(moments, chosen.stamps);
  remark_on_steps(log, chosen.stamps, steps);
  const std::vector<double> times = recorded_times(chosen.stamps, steps);
  const double begin = *std::min_element(times.begin(), times.end());
  add_mounts(log, std::max(ros::TIME_MIN, ros::Time().fromSec(begin)));
  add_events(std::move(log), chosen.stamps, times);
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return remarks_;
}

class CarmenMessages : public RecordedMessages {
 public:
  CarmenMessages(const std::vector<CarmenLog::Entry>& entries,
                 const std::map<std::uint32_t, BagConnection>& connections, BagSelection selection,
                 std::string damage)
      : at_(entries.begin()),
        end_(entries.end()),
        connections_(connections),
        selection_(std::move(selection)),
        damage_(std::move(damage)) {}

  std::optional<ros::Time> peek() override {
    while (at_ != end_ && (selection_.connections.count(at_->connection) == 0 ||
                           at_->time < selection_.first || at_->time > selection_.last)) {
      ++at_;
    }
    if (at_ == end_ && !damage_.empty()) {
      throw BagError(damage_);
    }
    return at_ != end_ ? std::optional(at_->time) : std::nullopt;
  }

  RecordedMessage next() override {
    const CarmenLog::Entry& entry = *at_++;
    return {entry.time, &connections_.at(entry.connection), entry.content};
  }

 private:
  std::vector<CarmenLog::Entry>::const_iterator at_;
  const std::vector<CarmenLog::Entry>::const_iterator end_;
  const std::map<std::uint32_t, BagConnection>& connections_;
  const BagSelection selection_;
  const std::string damage_;  ///< what to throw at the end; empty: nothing
};

}  // namespace

CarmenLog::CarmenLog(const std::string& path) : RecordingFile(path) {
  LogText log = read_log(path);
  if (!log.damage.empty()) {
    damage_ = fmt::format("log '{}' is damaged after line {} ({}); copy it again", path,
                          log.events.empty() ? 0 : log.events.back().number, log.damage);
  }
  const std::string first_bad = log.first_bad;
  remarks_ = MessageMaker(this->path(), connections_, entries_).make(std::move(log));
  if (entries_.empty()) {
    throw BagError(!damage_.empty() ? damage_
                                    : fmt::format("log '{}' of CARMEN holds no laser's readings{}",
                                                  path, first_bad.empty() ? "" : "; " + first_bad));
  }
}

std::unique_ptr<RecordedMessages> CarmenLog::messages(BagSelection selection) const {
  const bool reaches_end = !selection.connections.empty() && selection.last >= end_time();
  return std::make_unique<CarmenMessages>(entries_, connections_, std::move(selection),
                                          reaches_end ? damage_ : "");
}

}  // namespace matchbox_slam
