#include "io/tum.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <iomanip>
#include <locale>
#include <optional>
#include <sstream>
#include <vector>

#include "io/text_columns.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kColumnCount = 8;
constexpr std::array<const char*, kColumnCount> kColumns = {"stamp", "x",  "y",  "z",
                                                            "qx",    "qy", "qz", "qw"};
using Row = std::array<double, kColumnCount>;

/// How far from 1 the length of a quaternion may be: files with three decimals are still read.
constexpr double kQuaternionTolerance = 0.02;

StampedPose2 pose_of(const Row& row, const TextPlace& place) {
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

std::optional<StampedPose2> read_line(const std::string& line, const TextPlace& place) {
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
    row[i] = read_finite_number(words[i], kColumns[i], place);
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
