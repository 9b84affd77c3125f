#include "bag/bag_motion.hpp"

#include <fmt/core.h>

#include <cmath>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "ros/imu_heading.hpp"
#include "ros/message_conversion.hpp"
#include "ros/odometry_message.hpp"
#include "run/frames.hpp"

namespace matchbox_slam {
namespace {

constexpr const char* kOdometryType = "nav_msgs/Odometry";
constexpr const char* kImuType = "sensor_msgs/Imu";

/// What the first minute of a topic of odometry tells.
struct OdometryTopic {
  std::string name;
  std::string frame;  ///< of its pose
  std::string child;  ///< whose pose it is; empty: it does not say
  bool moves = false;
};

bool is_elsewhere(const Pose2& first, const Pose2& pose) {
  constexpr double kMinMotion = 0.01;  // [m] or [rad]: more than an estimate trembles at rest
  const Pose2 moved = first.inverse() * pose;
  return moved.translation().norm() > kMinMotion || std::abs(moved.theta) > kMinMotion;
}

/// None at the end, and where it cannot be read: that is told when it is mapped.
std::optional<BagMessage> next_of(BagStream& stream) {
  try {
    return stream.next();
  } catch (const BagError&) {
    return std::nullopt;
  }
}

OdometryTopic look_at(const BagReader& reader, const std::string& topic, BagPeriod period) {
  constexpr double kMaxStandstill = 60.0;  // [s] that a robot may stand before it moves
  period.duration = std::min(period.duration, kMaxStandstill);
  OdometryTopic found;
  found.name = topic;
  std::optional<Pose2> first;
  const std::unique_ptr<BagStream> stream = reader.stream({}, period, {}, {}, topic);
  while (!found.moves) {
    const std::optional<BagMessage> message = next_of(*stream);
    if (!message) {
      break;
    }
    const auto* content = std::get_if<nav_msgs::Odometry::ConstPtr>(&message->content);
    if (content == nullptr) {
      continue;
    }
    const nav_msgs::Odometry& odometry = **content;
    const std::string frame = without_leading_slash(odometry.header.frame_id);
    if (!find_defect(odometry, frame).empty()) {
      continue;
    }
    const Pose2 pose = to_pose2(odometry.pose.pose);
    if (!first) {
      first = pose;
      found.frame = frame;
      found.child = without_leading_slash(odometry.child_frame_id);
    }
    found.moves = is_elsewhere(*first, pose);
  }
  return found;
}

/// The frame of the first message of an IMU; empty: there is none that tells how it turns.
std::string frame_of_imu(const BagReader& reader, const std::string& topic,
                         const BagPeriod& period) {
  const std::unique_ptr<BagStream> stream = reader.stream({}, period, topic);
  while (const std::optional<BagMessage> message = next_of(*stream)) {
    if (const auto* imu = std::get_if<sensor_msgs::Imu::ConstPtr>(&message->content)) {
      const bool turns = has_no_orientation(**imu) ? GyroHeading::find_defect(**imu).empty()
                                                   : find_defect(**imu).empty();
      return turns ? without_leading_slash((*imu)->header.frame_id) : "";
    }
  }
  return "";
}

BagFrames frames_of(const OdometryTopic& topic, const BagSurvey& survey, const AskedFrames& asked) {
  const std::string odom = topic.frame.empty() ? "odom" : topic.frame;
  BagFrames frames;
  if (asked.base || topic.child.empty()) {
    frames.base = choose_frames(survey, asked.base, {}, false, asked.is_laser_placed).base;
  } else {
    frames.base = topic.child;
  }
  frames.odom = asked.odom.value_or(odom);
  return frames;
}

BagMotion by_topic(const OdometryTopic& topic, const BagSurvey& survey, const AskedFrames& asked) {
  BagMotion motion{frames_of(topic, survey, asked), topic.name, {}, {}};
  motion.told = fmt::format(
      "; odometry on topic {}, of {} in {}", topic.name,
      topic.child.empty() ? motion.frames.base + ", as it names no child_frame_id" : topic.child,
      *motion.frames.odom);
  return motion;
}

std::vector<OdometryTopic> look_at_all(const BagReader& reader, const BagPeriod& period) {
  std::vector<OdometryTopic> topics;
  for (const std::string& name : reader.topics_of(kOdometryType)) {
    topics.push_back(look_at(reader, name, period));
  }
  return topics;
}

std::string names_of(const std::vector<OdometryTopic>& topics) {
  std::vector<std::string> names;
  for (const OdometryTopic& topic : topics) {
    names.push_back(topic.name);
  }
  return join(names);
}

/// Where tf holds no odometry. None: no topic does, either.
std::optional<BagMotion> by_the_only_topic(const BagReader& reader, const BagSurvey& survey,
                                           const AskedFrames& asked, const BagPeriod& period) {
  const std::vector<OdometryTopic> all = look_at_all(reader, period);
  std::vector<OdometryTopic> moving;
  for (const OdometryTopic& topic : all) {
    if (topic.moves) {
      moving.push_back(topic);
    }
  }
  if (moving.size() > 1) {
    throw ConfigurationError(
        fmt::format("tf in the bag holds no odometry, and several topics do: {}; choose one with "
                    "--odom-topic, or give --no-odom",
                    names_of(moving)));
  }
  if (moving.size() == 1) {
    return by_topic(moving.front(), survey, asked);
  }
  if (!all.empty()) {
    throw ConfigurationError(fmt::format(
        "tf in the bag holds no odometry, and that on {} does not move in the first minute; to use "
        "it all the same give --odom-topic {}, to map from the laser alone --no-odom",
        names_of(all), all.front().name));
  }
  return std::nullopt;
}

/// Where there is no odometry and nobody has said to go without. None: there is no such IMU.
std::optional<BagMotion> by_the_only_imu(const BagReader& reader, const BagSurvey& survey,
                                         const AskedFrames& asked, const BagPeriod& period,
                                         const std::string& asked_imu) {
  const std::vector<std::string> topics =
      asked_imu.empty() ? reader.topics_of(kImuType) : std::vector<std::string>{asked_imu};
  if (topics.size() != 1) {
    return std::nullopt;
  }
  const BagFrames frames = choose_frames(survey, asked.base, {}, false, asked.is_laser_placed);
  const std::string imu = frame_of_imu(reader, topics.front(), period);
  if (imu.empty() || (imu != frames.base && !are_connected(survey, imu, frames.base))) {
    return std::nullopt;
  }
  return BagMotion{frames,
                   {},
                   topics.front(),
                   fmt::format("; there is no odometry, so the turn between scans is by the IMU on "
                               "{}; --no-odom leaves that aside, too",
                               topics.front())};
}

/// Without odometry, as was asked for.
BagMotion without_odometry(const BagReader& reader, const BagSurvey& survey,
                           const AskedFrames& asked, const RunOptions& options) {
  BagMotion motion{choose_frames(survey, asked.base, asked.odom, false, asked.is_laser_placed),
                   {},
                   {},
                   "; without odometry"};
  if (!options.imu_topic.empty()) {
    motion.imu_topic = find_imu_topic(reader, options.imu_topic);
    motion.told += ", the turn between scans by the IMU on " + motion.imu_topic;
  } else if (const auto topics = reader.topics_of(kImuType); !topics.empty()) {
    motion.told +=
        fmt::format("; the IMU on {} could tell the turn between scans: --set imu_topic={}",
                    join(topics), topics.front());
  }
  return motion;
}

}  // namespace

BagMotion choose_motion(const BagReader& reader, const BagSurvey& survey, const AskedFrames& asked,
                        const BagPeriod& period, const RunOptions& options) {
  if (!options.use_odometry) {
    return without_odometry(reader, survey, asked, options);
  }
  const std::string imu =
      options.imu_topic.empty() ? "" : find_imu_topic(reader, options.imu_topic);
  std::optional<BagMotion> motion;
  if (!options.odom_topic.empty()) {
    const std::string topic = find_odometry_topic(reader, options.odom_topic);
    motion = by_topic(look_at(reader, topic, period), survey, asked);
  } else if (!has_odometry(survey, asked.base, asked.odom, asked.is_laser_placed)) {
    motion = by_the_only_topic(reader, survey, asked, period);
    if (!motion && !asked.odom) {
      motion = by_the_only_imu(reader, survey, asked, period, imu);
    }
  }
  if (!motion) {
    motion = BagMotion{
        choose_frames(survey, asked.base, asked.odom, true, asked.is_laser_placed), {}, {}, {}};
    motion->told = "; odometry frame " + *motion->frames.odom;
  }
  motion->imu_topic = imu.empty() ? motion->imu_topic : imu;
  return *motion;
}

}  // namespace matchbox_slam
