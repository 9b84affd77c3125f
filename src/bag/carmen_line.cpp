#include "bag/carmen_line.hpp"

#include <fmt/core.h>

#include <clocale>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMostReadings = 100'000;
constexpr std::size_t kPoseWords = 3;
constexpr std::size_t kTailWords = 3;     // stamp, host, stamp
constexpr std::size_t kConfigWords = 7;   // of RAWLASER and ROBOTLASER, before the readings
constexpr double kCarmenMaxRange = 80.0;  // [m] CARMEN's own; farther readings are no return
constexpr double kLastStamp = 4294967295.0;

/// Messages that have nothing to map from, and the poses of a graph, which some logs have between
/// their scans.
bool is_left_aside(const std::string& message) {
  static const std::set<std::string, std::less<>> kNames = {"SYNC",
                                                            "TRUEPOS",
                                                            "LASER",
                                                            "LASER3",
                                                            "LASER4",
                                                            "SONAR",
                                                            "BUMPER",
                                                            "IMU",
                                                            "GYRO",
                                                            "WIFI",
                                                            "MARKER",
                                                            "SCANMARK",
                                                            "LASERPOS",
                                                            "POSITIONLASER",
                                                            "VECTORMOVE",
                                                            "VELOCITY",
                                                            "ROBOTVELOCITY",
                                                            "ARMSTATE",
                                                            "FOLLOWTRAJECTORY",
                                                            "BASEVELOCITY",
                                                            "BASEBUMPER",
                                                            "BASESONAR",
                                                            "MESSAGE_ID",
                                                            "XSENS",
                                                            "POINTCLOUD",
                                                            "GLOBALPOS",
                                                            "LOCALIZE",
                                                            "COMMENT",
                                                            "VERTEX2",
                                                            "EDGE2"};
  return kNames.count(message) > 0 || message.rfind("NMEA", 0) == 0;
}

/// Of RAWLASER1 the "RAWLASER"; empty: the message is no such name with one digit.
std::string numbered_kind(const std::string& message) {
  for (std::string kind : {"RAWLASER", "ROBOTLASER"}) {
    if (message.size() == kind.size() + 1 && message.rfind(kind, 0) == 0 && message.back() >= '1' &&
        message.back() <= '9') {
      return kind;
    }
  }
  return "";
}

bool is_read(const std::string& message) {
  return message == "PARAM" || message == "ODOM" || message == "FLASER" || message == "RLASER" ||
         !numbered_kind(message).empty();
}

double to_number(const char* text, char** end) {
  // Whatever the user's locale takes for a decimal point.
  static const locale_t kClassic = ::newlocale(LC_NUMERIC_MASK, "C", nullptr);
  return ::strtod_l(text, end, kClassic);
}

/// The words of a line one after the other.
class Words {
 public:
  explicit Words(const std::string& line) {
    constexpr const char* kBlanks = " \t\r";
    for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string::npos;) {
      const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
      words_.push_back(std::string_view(line).substr(begin, end - begin));
      begin = line.find_first_not_of(kBlanks, end);
    }
  }

  [[nodiscard]] std::size_t left() const { return words_.size() - at_; }

  [[nodiscard]] std::string next(const std::string& what) {
    require(1, what);
    return std::string(words_[at_++]);
  }

  [[nodiscard]] double number(const std::string& what) {
    require(1, what);
    const std::optional<double> value = number_at(at_++);
    if (!value || !std::isfinite(*value)) {
      throw CarmenLineError(fmt::format("{} is '{}', which is no number", what, words_[at_ - 1]));
    }
    return *value;
  }

  /// A number of things that follow.
  [[nodiscard]] std::size_t count(const std::string& what) {
    const double value = number("the number of " + what);
    if (value < 0.0 || value > static_cast<double>(kMostReadings) || value != std::floor(value)) {
      throw CarmenLineError(fmt::format("the number of {} is '{}'; allowed: 0 to {}", what,
                                        words_[at_ - 1], kMostReadings));
    }
    return static_cast<std::size_t>(value);
  }

  /// Readings [m]; those that are no finite numbers stay so.
  [[nodiscard]] std::vector<float> readings(std::size_t count, const std::string& what) {
    require(count, what);
    std::vector<float> values;
    values.reserve(count);
    for (std::size_t k = 0; k < count; ++k, ++at_) {
      const std::optional<double> value = number_at(at_);
      if (!value) {
        throw CarmenLineError(
            fmt::format("number {} of {} is '{}', which is no number", k + 1, what, words_[at_]));
      }
      constexpr double kLargest = std::numeric_limits<float>::max();
      values.push_back(std::abs(*value) > kLargest ? std::numeric_limits<float>::infinity()
                                                   : static_cast<float>(*value));
    }
    return values;
  }

  [[nodiscard]] Pose2 pose(const std::string& what) {
    const double x = number(what);
    const double y = number(what);
    return {x, y, wrap_angle(number(what))};
  }

  void skip(std::size_t count, const std::string& what) {
    require(count, what);
    at_ += count;
  }

  /// Whether the line ends with stamp, host and stamp: the word before the last is no number.
  [[nodiscard]] bool has_host() const {
    return left() >= kTailWords && !number_at(words_.size() - 2);
  }

  /// Of the word so many after the next.
  [[nodiscard]] bool has_decimal_point(std::size_t ahead) const {
    return ahead < left() && words_[at_ + ahead].find('.') != std::string_view::npos;
  }

  /// A count, without taking it; none where the next word is not of digits alone.
  [[nodiscard]] std::optional<std::size_t> count_ahead() const {
    const bool is_count = at_ < words_.size() && words_[at_].size() < 7 &&
                          words_[at_].find_first_not_of("0123456789") == std::string_view::npos;
    return is_count ? std::optional<std::size_t>(std::stoul(std::string(words_[at_])))
                    : std::nullopt;
  }

 private:
  void require(std::size_t count, const std::string& what) const {
    if (count > left()) {
      throw CarmenLineError(
          fmt::format("{}{} of {} should follow where {} are left; it may be cut off", count,
                      count == 1 ? " word" : " words", what, left()));
    }
  }

  [[nodiscard]] std::optional<double> number_at(std::size_t place) const {
    const std::string_view word = words_[place];
    char* end = nullptr;
    const double value = to_number(word.data(), &end);  // a blank or the line's end follows
    return end == word.data() + word.size() ? std::optional(value) : std::nullopt;
  }

  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
};

/// The stamps at the end of a line. Some logs have none, some the first alone.
void read_tail(Words& words, CarmenLine& line) {
  if (words.left() == 0) {
    return;
  }
  line.ipc_stamp = words.number("its stamp");
  if (*line.ipc_stamp < 0.0 || *line.ipc_stamp > kLastStamp) {
    throw CarmenLineError("its stamp is before 1970 or after 2106");
  }
  if (words.left() > 0) {
    words.skip(1, "host");
  }
  if (words.left() > 0) {
    constexpr double kMaxLoggerStamp = 1e9;  // s, 30 years
    line.logger_stamp = words.number("the logger's stamp");
    if (*line.logger_stamp < 0.0 || *line.logger_stamp > kMaxLoggerStamp) {
      throw CarmenLineError("the logger's stamp is before its beginning or 30 years after it");
    }
  }
}

/// CARMEN's own guess, of SICK's scanners, which leaves out the last beam of an even number.
double usual_increment(std::size_t beams) {
  switch (beams) {
    case 180:
    case 181:
      return kPi / 180.0;
    case 360:
    case 361:
      return kPi / 360.0;
    case 400:
    case 401:
      return kPi / 720.0;
    default:
      return beams > 1 ? kPi / static_cast<double>(beams - 1) : 0.0;
  }
}

CarmenScan read_old_scan(Words& words, const std::string& message) {
  CarmenScan scan;
  scan.message = message;
  const std::size_t beams = words.count("readings");
  scan.ranges = words.readings(beams, "readings");
  scan.start_angle = -0.5 * kPi;
  scan.increment = usual_increment(beams);
  scan.maximum_range = kCarmenMaxRange;
  scan.laser = words.pose("the laser's pose");
  scan.robot = words.pose("the robot's pose");
  return scan;
}

/// Whether their count and remissions follow, and then so many words of the message.
bool are_remissions_ahead(const Words& words, std::size_t words_after) {
  const std::optional<std::size_t> count = words.count_ahead();
  const std::size_t tail = words.has_host() ? kTailWords : 0;
  return count && words.left() == 1 + *count + words_after + tail;
}

/// Older logs have none.
void read_remissions(Words& words, CarmenScan& scan) {
  scan.remissions = words.readings(words.count("remissions"), "remissions");
}

/// Of a ROBOTLASER, with the turn axis at its end or without, as older logs have it. A count of 0
/// without an axis has as many words as an axis without a count: there, a whole number before
/// numbers with a decimal point is the count.
bool has_remissions(const Words& words, std::size_t words_with_axis) {
  return are_remissions_ahead(words, words_with_axis) ||
         (are_remissions_ahead(words, words_with_axis - 1) &&
          (words.count_ahead() != 0 || words.has_decimal_point(1)));
}

CarmenScan read_new_scan(Words& words, const std::string& message) {
  CarmenScan scan;
  scan.message = message;
  if (words.left() < kConfigWords + 1) {
    throw CarmenLineError("it ends before its readings; it may be cut off");
  }
  words.skip(1, "the laser's type");
  scan.tells_angles = true;
  scan.start_angle = words.number("the start angle");
  const double field_of_view = words.number("the field of view");
  scan.increment = words.number("the angular resolution");
  const double maximum_range = words.number("the maximum range");
  words.skip(2, "accuracy and remission mode");
  const std::size_t beams = words.count("readings");
  scan.ranges = words.readings(beams, "readings");
  scan.maximum_range =
      maximum_range > 0.0 ? std::min(maximum_range, kCarmenMaxRange) : kCarmenMaxRange;
  if (scan.increment == 0.0 && beams > 1) {
    scan.increment = field_of_view / static_cast<double>(beams - 1);
  }
  if (numbered_kind(message) == "RAWLASER") {
    if (are_remissions_ahead(words, 0)) {
      read_remissions(words, scan);
    }
    return scan;
  }
  constexpr std::size_t kDriveWords = 5;  // two velocities, two distances, the turn axis
  constexpr std::size_t kBodyWords = 2 * kPoseWords + kDriveWords;
  if (has_remissions(words, kBodyWords)) {
    read_remissions(words, scan);
  }
  scan.laser = words.pose("the laser's pose");
  scan.robot = words.pose("the robot's pose");
  // Older logs have no turn axis.
  const bool has_axis = words.left() == kDriveWords || words.left() == kDriveWords + kTailWords;
  words.skip(has_axis ? kDriveWords : kDriveWords - 1, "the robot's motion");
  return scan;
}

/// Of the places of lasers alone the values are numbers that matter.
CarmenParameter read_parameter(Words& words) {
  CarmenParameter parameter;
  parameter.name = words.next("a parameter");
  if (parameter.name.find("laser_") != std::string::npos &&
      parameter.name.find("offset") != std::string::npos) {
    parameter.value = words.number(parameter.name);
  }
  return parameter;
}

CarmenOdometry read_odometry(Words& words) {
  constexpr std::size_t kMotionWords = 3;  // two velocities and the acceleration
  const CarmenOdometry odometry{words.pose("the robot's pose")};
  words.skip(kMotionWords, "the robot's motion");
  return odometry;
}

}  // namespace

CarmenLine parse_carmen_line(const std::string& text) {
  CarmenLine line;
  Words words(text);
  if (words.left() == 0 || text.front() == '#') {
    return line;
  }
  const std::string message = words.next("message");
  if (message == "PARAM") {
    line.content = read_parameter(words);
  } else if (message == "ODOM") {
    line.content = read_odometry(words);
    read_tail(words, line);
  } else if (is_read(message)) {
    line.content = message == "FLASER" || message == "RLASER" ? read_old_scan(words, message)
                                                              : read_new_scan(words, message);
    read_tail(words, line);
  } else if (!is_left_aside(message)) {
    throw CarmenLineError(fmt::format("'{}' is no message of CARMEN", message.substr(0, 20)));
  }
  return line;
}

bool is_carmen_line(const std::string& line) {
  if (line.rfind("# CARMEN", 0) == 0) {
    return true;
  }
  const std::string message = line.substr(0, line.find(' '));
  return message.size() < line.size() && (is_read(message) || is_left_aside(message));
}

}  // namespace matchbox_slam
