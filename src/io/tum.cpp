#include "io/tum.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <ostream>
#include <vector>

#include "io/paged_text.hpp"
#include "io/text_columns.hpp"

namespace matchbox_slam {
namespace {

const TextFormat kTumFormat{{"stamp", "x", "y", "z", "qx", "qy", "qz", "qw"},
                            "; a TUM trajectory has 8: stamp x y z qx qy qz qw"};

/// How far from 1 the length of a quaternion may be: files with three decimals are still read.
constexpr double kQuaternionTolerance = 0.02;

StampedPose2 tum_pose(const std::vector<double>& row, const TextPlace& place) {
  const Eigen::Quaterniond q(row[7], row[4], row[5], row[6]);
  if (std::abs(q.norm() - 1.0) > kQuaternionTolerance) {
    place.fail(fmt::format("the quaternion (qx qy qz qw) has the length {:g}, not 1", q.norm()));
  }
  const double yaw = std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()),
                                q.w() * q.w() + q.x() * q.x() - q.y() * q.y() - q.z() * q.z());
  return {row[0], {row[1], row[2], wrap_angle(yaw)}};
}

}  // namespace

Trajectory parse_tum(const std::string& text, const std::string& source) {
  return read_trajectory(text, source, kTumFormat, tum_pose);
}

Trajectory read_tum(const std::string& path) { return parse_tum(read_file(path), path); }

void write_tum(const Trajectory& trajectory, const ByteSink& sink) {
  PagedText text(sink);
  text.line() << std::fixed;
  for (const StampedPose2& stamped : trajectory.poses()) {
    const Pose2& pose = stamped.pose;
    text.line() << std::setprecision(6) << stamped.stamp << std::setprecision(9) << ' ' << pose.x
                << ' ' << pose.y << ' ' << 0.0 << ' ' << 0.0 << ' ' << 0.0 << ' '
                << std::sin(0.5 * pose.theta) << ' ' << std::cos(0.5 * pose.theta);
    text.end_line();
  }
  text.finish();
}

std::string to_tum(const Trajectory& trajectory) {
  return text_of_pages([&](const ByteSink& sink) { write_tum(trajectory, sink); });
}

std::string path_of_part(const std::string& path, std::size_t part, std::size_t parts) {
  if (part + 1 == parts) {
    return path;
  }
  const std::filesystem::path whole(path);
  std::filesystem::path named = whole.parent_path() / whole.stem();
  named += fmt::format(".{}{}", part + 1, whole.extension().string());
  return named.string();
}

void add_tum_parts(const std::string& path, const std::vector<std::vector<StampedPose2>>& parts,
                   const std::string& comment, FileReplacement& files) {
  for (std::size_t part = 0; part < parts.size(); ++part) {
    files.add(path_of_part(path, part, parts.size()), [&](const ByteSink& sink) {
      if (!comment.empty()) {
        sink(fmt::format("# {}\n", comment));
      }
      write_tum(Trajectory(parts[part]), sink);
    });
  }
}

void write_tum(const std::string& path, const Trajectory& trajectory) {
  replace_file(path, to_tum(trajectory));
}

}  // namespace matchbox_slam
