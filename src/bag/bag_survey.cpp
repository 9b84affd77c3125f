#include "bag/bag_survey.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "matchbox_slam/common/options.hpp"
#include "ros/clock_comparison.hpp"
#include "ros/message_conversion.hpp"
#include "ros/transform_store.hpp"
#include "sensor/max_range_detector.hpp"

namespace matchbox_slam {

namespace {

// Guesses: half and double were not tried. Logs with a scan each metre have so many after minutes.
constexpr double kSurveySeconds = 10.0;
constexpr double kLongestSurvey = 120.0;  // [s]
constexpr std::size_t kSurveyScans = 60;  // of all lasers together: frames and clocks are theirs
const std::set<std::string> kNoParents;

std::string list_of(const std::vector<std::string>& words) {
  return words.empty() ? "none" : join(words);
}

void add_transforms(const BagTransforms& transforms, const ros::Time& recorded, BagSurvey& survey,
                    ClockComparison& clocks) {
  for (const geometry_msgs::TransformStamped& transform : transforms.message->transforms) {
    const std::string parent = without_leading_slash(transform.header.frame_id);
    const std::string child = without_leading_slash(transform.child_frame_id);
    if (parent == child) {
      continue;
    }
    if (parent == survey.map_frame || child == survey.map_frame) {
      survey.map_links.insert(fmt::format("{} -> {}", parent, child));
      continue;
    }
    survey.parents[child].insert(parent);
    if (!transforms.is_static) {
      survey.on_tf.insert(child);
      clocks.add_transform(transform, recorded);
    }
  }
}

/// That tf has no odometry, or nothing of the laser. The frame that was meant for the map may be
/// the robot's own, whose links are left out then.
[[noreturn]] void refuse_tf(const BagSurvey& survey, const std::string& why) {
  throw ConfigurationError(
      survey.map_links.empty()
          ? why
          : fmt::format("map_frame: tf has '{0}' itself, and what touches it is left out ({1}); if "
                        "that is the robot's own, as its odometry, give the map another name: "
                        "--set map_frame={2}; without it {3}",
                        survey.map_frame,
                        list_of({survey.map_links.begin(), survey.map_links.end()}),
                        survey.map_frame == "map" ? "slam_map" : "map", why));
}

/// The next message. Where the bag is damaged after a scan, what was seen before has to do.
std::optional<BagMessage> next_of(BagStream& stream, BagSurvey& survey) {
  try {
    return stream.next();
  } catch (const BagError& error) {
    if (survey.scan_frame.empty()) {
      throw;
    }
    survey.damage = error.what();
    return std::nullopt;
  }
}

/// The next scan; none, too, where the bag is damaged, which whoever maps it is told.
std::optional<BagMessage> next_scan(BagStream& stream) {
  try {
    std::optional<BagMessage> message;
    do {
      message = stream.next();
    } while (message && !std::holds_alternative<ScanMessage>(message->content));
    return message;
  } catch (const BagError&) {
    return std::nullopt;
  }
}

/// The frames from `frame` up to the root of its tree. Throws ConfigurationError at a frame that
/// hangs in several places.
std::vector<std::string> way_to_root(const BagSurvey& survey, const std::string& frame) {
  std::vector<std::string> way = {frame};
  for (auto at = survey.parents.find(frame); at != survey.parents.end();
       at = survey.parents.find(way.back())) {
    if (at->second.size() > 1) {
      throw ConfigurationError(fmt::format(
          "frame '{}' has several parents in tf: {}; say which with --odom-frame and --base-frame",
          way.back(), list_of({at->second.begin(), at->second.end()})));
    }
    const std::string& parent = *at->second.begin();
    if (std::find(way.begin(), way.end(), parent) != way.end()) {
      throw ConfigurationError(fmt::format("tf goes in a circle at frame '{}'", parent));
    }
    way.push_back(parent);
  }
  return way;
}

/// The frame below `odom` on the way from the laser.
std::string base_below(const BagSurvey& survey, const std::string& odom) {
  const std::vector<std::string> way = way_to_root(survey, survey.scan_frame);
  const auto at = std::find(way.begin(), way.end(), odom);
  if (at == way.end() || at == way.begin()) {
    throw ConfigurationError(
        fmt::format("odometry frame '{}' is not above the scan's frame in tf; above it are: {}; "
                    "give another --odom-frame, or --no-odom",
                    odom, list_of({way.begin() + 1, way.end()})));
  }
  return *(at - 1);
}

/// Whether a frame hangs below another in tf, by any of its parents.
bool is_below(const BagSurvey& survey, const std::string& frame, const std::string& other) {
  std::vector<std::string> above = {frame};
  for (std::size_t k = 0; k < above.size(); ++k) {
    const auto at = survey.parents.find(above[k]);
    for (const std::string& parent : at != survey.parents.end() ? at->second : kNoParents) {
      if (parent == other) {
        return true;
      }
      if (std::find(above.begin(), above.end(), parent) == above.end()) {
        above.push_back(parent);
      }
    }
  }
  return false;
}

/// Whether a frame goes by the name that odometry has by convention, in any namespace.
bool is_named_odometry(const std::string& frame) {
  const std::string name = frame.substr(frame.rfind('/') + 1);
  return name == "odom" || name == "odom_combined";
}

/// A link of tf, from child to parent.
struct OdometryLink {
  std::string base;
  std::string odom;
};

/// The link on a way to the root that is the odometry. By its name it may be one that does not
/// move: a robot may stand still throughout the survey.
std::optional<OdometryLink> find_odometry(const BagSurvey& survey,
                                          const std::vector<std::string>& way) {
  std::optional<OdometryLink> moving;
  for (std::size_t k = way.size() - 1; k > 0; --k) {
    const std::string& base = way[k - 1];
    if (survey.on_tf.count(base) != 0 && is_named_odometry(way[k])) {
      return OdometryLink{base, way[k]};
    }
    if (!moving && survey.moving.count(base) != 0) {
      moving = OdometryLink{base, way[k]};
    }
  }
  return moving;
}

/// The links of tf that may be odometry, wherever they are: those that go by its name, else those
/// that move.
std::vector<OdometryLink> possible_odometry(const BagSurvey& survey) {
  std::vector<OdometryLink> named;
  std::vector<OdometryLink> moving;
  for (const std::string& base : survey.on_tf) {
    for (const std::string& parent : survey.parents.at(base)) {
      if (is_named_odometry(parent)) {
        named.push_back({base, parent});
      } else if (survey.moving.count(base) != 0) {
        moving.push_back({base, parent});
      }
    }
  }
  return named.empty() ? moving : named;
}

/// The frames of a robot whose laser has no place in tf.
BagFrames frames_without_laser(const BagSurvey& survey, const std::optional<std::string>& base,
                               const std::optional<std::string>& odom, bool use_odometry) {
  std::vector<OdometryLink> links = possible_odometry(survey);
  links.erase(std::remove_if(links.begin(), links.end(),
                             [&](const OdometryLink& link) {
                               return (base && link.base != *base) || (odom && link.odom != *odom);
                             }),
              links.end());
  if (links.size() == 1) {
    return {links.front().base, use_odometry ? std::optional(links.front().odom) : std::nullopt};
  }
  if (base && (!use_odometry || odom)) {
    return {*base, use_odometry ? odom : std::nullopt};
  }
  if (!use_odometry && links.empty()) {
    return {survey.scan_frame == "base_link" ? "base" : "base_link", std::nullopt};
  }
  std::vector<std::string> names;
  for (const OdometryLink& link : links) {
    names.push_back(fmt::format("{} -> {}", link.odom, link.base));
  }
  if (links.empty()) {
    refuse_tf(survey,
              "tf in the bag holds no link that moves, so there is no odometry; to map from "
              "the laser alone give --no-odom, or name --odom-frame and --base-frame; tf has " +
                  text_of_frames(survey));
  }
  throw ConfigurationError(
      fmt::format("tf in the bag has several links that move: {}; say which with "
                  "--odom-frame and --base-frame",
                  list_of(names)));
}

/// The frame that would be the base with odometry; the root where there is none; the laser's own
/// where there is no tf.
std::string base_without_odometry(const BagSurvey& survey) {
  const std::vector<std::string> way = way_to_root(survey, survey.scan_frame);
  const std::optional<OdometryLink> odometry = find_odometry(survey, way);
  return odometry ? odometry->base : way.back();
}

std::vector<std::string> topics_of(const BagReader& reader, const std::vector<std::string>& types) {
  std::vector<std::string> topics;
  for (const std::string& type : types) {
    for (const std::string& topic : reader.topics_of(type)) {
      topics.push_back(topic);
    }
  }
  return topics;
}

/// The bag's topic of this name. Throws ConfigurationError when there is none with such messages.
/// @param things  what they are, for people.
std::string find_topic(const BagReader& reader, const std::string& asked,
                       const std::vector<std::string>& types, const std::string& things) {
  const std::string there =
      fmt::format("; topics with {}: {}", things, list_of(topics_of(reader, types)));
  for (const BagTopic& topic : reader.topics()) {
    if (without_leading_slash(topic.name) != without_leading_slash(asked)) {
      continue;
    }
    if (std::count(types.begin(), types.end(), topic.type) > 0) {
      return topic.name;
    }
    throw ConfigurationError(fmt::format("topic '{}' of the bag holds {}, not {}{}", asked,
                                         topic.type, join(types), there));
  }
  throw ConfigurationError(fmt::format("the bag has no topic '{}'{}", asked, there));
}

}  // namespace

std::string text_of_frames(const BagSurvey& survey) {
  std::set<std::string> frames;
  for (const auto& [child, parents] : survey.parents) {
    frames.insert(child);
    frames.insert(parents.begin(), parents.end());
  }
  return list_of({frames.begin(), frames.end()});
}

bool are_connected(const BagSurvey& survey, const std::string& a, const std::string& b) {
  std::set<std::string> found = {a};
  for (std::size_t before = 0; before != found.size();) {
    before = found.size();
    for (const auto& [child, parents] : survey.parents) {
      for (const std::string& parent : parents) {
        if (found.count(child) != 0 || found.count(parent) != 0) {
          found.insert({child, parent});
        }
      }
    }
  }
  return found.count(b) != 0;
}

bool has_odometry(const BagSurvey& survey, const std::optional<std::string>& asked_base,
                  const std::optional<std::string>& asked_odom, bool is_laser_placed) {
  if (asked_odom) {
    return std::any_of(survey.parents.begin(), survey.parents.end(), [&](const auto& link) {
      return link.first == *asked_odom || link.second.count(*asked_odom) != 0;
    });
  }
  if (is_laser_placed && survey.parents.count(survey.scan_frame) == 0) {
    return !possible_odometry(survey).empty();
  }
  try {
    return find_odometry(survey, way_to_root(survey, asked_base.value_or(survey.scan_frame)))
        .has_value();
  } catch (const ConfigurationError&) {
    return true;  // it cannot be told which
  }
}

BagSurvey survey_bag(const BagReader& reader, const std::vector<std::string>& scan_topics,
                     const BagPeriod& period, const std::string& map_frame,
                     const std::function<bool()>& is_interrupted, const CloudOptions& cloud,
                     bool is_laser_placed) {
  BagSurvey survey;
  survey.map_frame = map_frame;
  ClockComparison clocks;
  std::optional<ros::Time> begin;
  std::size_t scans = 0;
  const std::unique_ptr<BagStream> stream = reader.stream(scan_topics, period, {}, cloud);
  while (const std::optional<BagMessage> message = next_of(*stream, survey)) {
    if (is_interrupted && is_interrupted()) {
      break;
    }
    if (const auto* transforms = std::get_if<BagTransforms>(&message->content)) {
      add_transforms(*transforms, message->time, survey, clocks);
      if (transforms->is_static) {
        continue;  // may be from long before the period
      }
    } else {
      const auto& scan = std::get<ScanMessage>(message->content).scan;
      ++scans;
      if (message->laser == 0) {
        survey.scan_frame = without_leading_slash(scan->header.frame_id);
      }
      clocks.add_scan(scan->header.stamp, message->time);
    }
    begin = begin ? begin : message->time;
    const bool knows_place =
        is_laser_placed ? !survey.scan_frame.empty() : survey.parents.count(survey.scan_frame) != 0;
    const double seconds = scans < kSurveyScans ? kLongestSurvey : kSurveySeconds;
    if (seconds_between(*begin, message->time) > seconds && knows_place) {
      break;
    }
  }
  survey.moving = clocks.moving();
  survey.scan_time_offset = clocks.offset();
  return survey;
}

std::optional<double> find_no_returns(const BagReader& reader,
                                      const std::vector<std::string>& scan_topics,
                                      const std::function<bool()>& is_interrupted,
                                      const CloudOptions& cloud) {
  const std::unique_ptr<BagStream> stream = reader.stream(scan_topics, {}, {}, cloud);
  std::map<int, MaxRangeDetector> detectors;
  std::optional<ros::Time> begin;
  while (const std::optional<BagMessage> message = next_scan(*stream)) {
    begin = begin ? begin : message->time;
    if (seconds_between(*begin, message->time) > kLongestSurvey ||
        (is_interrupted && is_interrupted())) {
      break;
    }
    const auto& scan = std::get<ScanMessage>(message->content).scan;
    MaxRangeDetector& detector = detectors[message->laser];
    if (!detector.is_complete() && find_defect(*scan).empty()) {
      detector.add(to_laser_scan(*scan));
      if (detector.first_range()) {
        return detector.first_range();
      }
    }
    if (detectors.size() == scan_topics.size() &&
        std::all_of(detectors.begin(), detectors.end(),
                    [](const auto& one) { return one.second.is_complete(); })) {
      break;
    }
  }
  return std::nullopt;
}

std::string text_of_no_scans(const BagReader& reader) {
  std::vector<std::string> topics;
  for (const BagTopic& topic : reader.topics()) {
    topics.push_back(fmt::format("{} ({})", topic.name, topic.type));
  }
  return fmt::format("the bag has no topic of type {}; it has: {}; record the laser's topic, too",
                     join(scan_types()), list_of(topics));
}

std::vector<std::string> choose_scan_topics(const BagReader& reader,
                                            const std::vector<std::string>& asked) {
  std::vector<std::string> chosen;
  for (const std::string& topic : asked) {
    chosen.push_back(find_topic(reader, topic, scan_types(), "laser scans"));
    if (std::count(chosen.begin(), chosen.end(), chosen.back()) > 1) {
      throw ConfigurationError(fmt::format("topic '{}' is named twice", topic));
    }
  }
  if (!chosen.empty()) {
    return chosen;
  }
  std::vector<std::string> candidates;
  for (auto type = scan_types().begin(); candidates.empty() && type != scan_types().end(); ++type) {
    candidates = reader.topics_of(*type);
  }
  if (candidates.empty()) {
    throw ConfigurationError(text_of_no_scans(reader));
  }
  if (candidates.size() > 1) {
    throw ConfigurationError(
        fmt::format("the bag has several topics with laser scans: {}; choose one with "
                    "--scan-topic, or several by giving it for each",
                    list_of(candidates)));
  }
  return candidates;
}

std::string find_odometry_topic(const BagReader& reader, const std::string& asked) {
  return find_topic(reader, asked, {"nav_msgs/Odometry"}, "odometry");
}

std::string find_imu_topic(const BagReader& reader, const std::string& asked) {
  return find_topic(reader, asked, {"sensor_msgs/Imu"}, "orientations of an IMU");
}

BagFrames choose_frames(const BagSurvey& survey, const std::optional<std::string>& asked_base,
                        const std::optional<std::string>& asked_odom, bool use_odometry,
                        bool is_laser_placed) {
  const bool has_tf = survey.parents.count(survey.scan_frame) != 0;
  if (is_laser_placed && !has_tf) {
    return frames_without_laser(survey, asked_base, asked_odom, use_odometry);
  }
  if (!use_odometry) {
    return {asked_base ? *asked_base : base_without_odometry(survey), std::nullopt};
  }
  if (asked_base && asked_odom) {
    if (is_below(survey, *asked_odom, *asked_base)) {
      throw ConfigurationError(text_of_swapped_frames(*asked_base, *asked_odom));
    }
    return {*asked_base, asked_odom};
  }
  if (asked_odom) {
    return {base_below(survey, *asked_odom), asked_odom};
  }
  if (!has_tf && !asked_base) {
    refuse_tf(survey,
              fmt::format("tf in the bag says nothing of the scan's frame '{}', so there is no "
                          "odometry; to map from "
                          "the laser alone give --no-odom{}",
                          survey.scan_frame,
                          survey.parents.empty()
                              ? ""
                              : ", or say where the laser is on the robot with --laser-pose "
                                "X,Y,YAW; tf has " +
                                    text_of_frames(survey)));
  }
  const std::vector<std::string> way = way_to_root(survey, asked_base.value_or(survey.scan_frame));
  if (way.size() < 2) {
    refuse_tf(
        survey,
        fmt::format("tf in the bag has no frame above base frame '{}'; to map without odometry "
                    "give --no-odom{}",
                    way.front(),
                    survey.parents.count(way.front()) == 0
                        ? ", or another --base-frame; tf has " + text_of_frames(survey)
                        : ""));
  }
  const std::optional<OdometryLink> odometry = find_odometry(survey, way);
  if (!odometry) {
    refuse_tf(
        survey,
        "tf holds no link that moves, so there is no odometry; to map from the laser alone give "
        "--no-odom, or name --odom-frame and --base-frame");
  }
  return {asked_base.value_or(odometry->base), odometry->odom};
}

}  // namespace matchbox_slam
