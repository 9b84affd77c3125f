#include "matchbox_slam/io/tum.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <iomanip>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <vector>

#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kColumnCount = 8;
constexpr std::array<const char*, kColumnCount> kColumns = {"stamp", "x",  "y",  "z",
                                                            "qx",    "qy", "qz", "qw"};
using Row = std::array<double, kColumnCount>;

/// How far from 1 the length of a quaternion may be: files with three decimals are still read.
constexpr double kQuaternionTolerance = 0.02;

/// Where in which file, for errors.
struct Place {
  const std::string& source;
  std::size_t line;

  [[noreturn]] void fail(const std::string& text) const {
    throw FileError(source + ":" + std::to_string(line) + ": " + text);
  }
};

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line.substr(0, line.find('#')));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    words.push_back(word);
  }
  return words;
}

double read_number(const std::string& word, const char* column, const Place& place) {
  const ParameterValue value = parse_parameter_value(word);
  double number = std::numeric_limits<double>::quiet_NaN();
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    number = static_cast<double>(*whole);
  } else if (const auto* real = std::get_if<double>(&value)) {
    number = *real;
  }
  if (!std::isfinite(number)) {
    place.fail(std::string(column) + " is '" + word + "', not a finite number");
  }
  return number;
}

StampedPose2 pose_of(const Row& row, const Place& place) {
  const auto& [stamp, x, y, z, qx, qy, qz, qw] = row;
  const double length = std::sqrt(qx * qx + qy * qy + qz * qz + qw * qw);
  if (std::abs(length - 1.0) > kQuaternionTolerance) {
    std::ostringstream text;
    text << "the quaternion (qx qy qz qw) has the length " << length << ", not 1";
    place.fail(text.str());
  }
  const double yaw = std::atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz);
  return {stamp, {x, y, wrap_angle(yaw)}};
}

std::optional<StampedPose2> read_line(const std::string& line, const Place& place) {
  const std::vector<std::string> words = words_of(line);
  if (words.empty()) {
    return std::nullopt;
  }
  if (words.size() != kColumnCount) {
    place.fail("has " + std::to_string(words.size()) +
               " columns; a TUM trajectory has 8: stamp x y z qx qy qz qw");
  }
  Row row{};
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    row[i] = read_number(words[i], kColumns[i], place);
  }
  return pose_of(row, place);
}

}  // namespace

Trajectory parse_tum(const std::string& text, const std::string& source) {
  std::vector<StampedPose2> poses;
  std::istringstream stream(text);
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    if (const std::optional<StampedPose2> pose = read_line(line, {source, ++number})) {
      poses.push_back(*pose);
    }
  }
  try {
    return Trajectory(std::move(poses));
  } catch (const EvaluationError& error) {
    throw FileError(source + ": " + error.what());
  }
}

Trajectory read_tum(const std::string& path) { return parse_tum(read_file(path), path); }

std::string to_tum(const Trajectory& trajectory) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::fixed;
  for (const StampedPose2& stamped : trajectory.poses()) {
    const Pose2& pose = stamped.pose;
    text << std::setprecision(6) << stamped.stamp << std::setprecision(9) << ' ' << pose.x << ' '
         << pose.y << ' ' << 0.0 << ' ' << 0.0 << ' ' << 0.0 << ' ' << std::sin(0.5 * pose.theta)
         << ' ' << std::cos(0.5 * pose.theta) << '\n';
  }
  return text.str();
}

void write_tum(const std::string& path, const Trajectory& trajectory) {
  replace_file(path, to_tum(trajectory));
}

}  // namespace matchbox_slam
