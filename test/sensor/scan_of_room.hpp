#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

inline constexpr float kInf = std::numeric_limits<float>::infinity();

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// The walls of the test room: x = -3, x = 4, y = -2, y = 5.
inline const Eigen::Vector2d kLow(-3.0, -2.0);

inline const Eigen::Vector2d kHigh(4.0, 5.0);

/// How far a step vector fits from a point inside the room until it meets a wall.
inline double steps_to_wall(const Eigen::Vector2d& origin, const Eigen::Vector2d& step) {
  double steps = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    if (step(axis) != 0.0) {
      const double wall = step(axis) > 0.0 ? kHigh(axis) : kLow(axis);
      steps = std::min(steps, (wall - origin(axis)) / step(axis));
    }
  }
  return steps;
}

inline double distance_to_walls(const Eigen::Vector2d& point) {
  return std::min((point - kLow).cwiseAbs().minCoeff(), (point - kHigh).cwiseAbs().minCoeff());
}

inline LaserScan sweep(std::size_t beams, double field_of_view) {
  LaserScan scan;
  scan.stamp = 17.25;
  scan.angle_min = -0.5 * field_of_view;
  scan.angle_increment = beams > 1 ? field_of_view / static_cast<double>(beams - 1) : 0.0;
  scan.range_min = 0.05;
  scan.range_max = 20.0;
  scan.ranges.assign(beams, kNan);
  return scan;
}

inline double angle_of(const LaserScan& scan, std::size_t beam) {
  return scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
}

/// What a laser measures in the room, mounted anyhow, on a base that moves at constant speed from
/// the origin to `motion` while the beams are swept.
inline void measure(LaserScan& scan, const Eigen::Isometry3d& base_from_laser,
                    const Pose2& motion = {}) {
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const double angle = angle_of(scan, k);
    const Eigen::Vector3d direction =
        base_from_laser.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const double last = std::max<double>(1.0, static_cast<double>(scan.ranges.size()) - 1.0);
    const Pose2 room_from_base = interpolate({}, motion, static_cast<double>(k) / last);
    const Pose2 turn_only{0.0, 0.0, room_from_base.theta};
    scan.ranges[k] = static_cast<float>(
        steps_to_wall(room_from_base * Eigen::Vector2d(base_from_laser.translation().head<2>()),
                      turn_only * Eigen::Vector2d(direction.head<2>())));
  }
}

inline Eigen::Isometry3d mount(double x, double y, double roll, double pitch, double yaw) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x, y, 0.3);
  pose.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

/// Options without limits that matter in the room, so that a test states what it depends on.
inline ProjectionOptions plain() {
  ProjectionOptions options;
  options.min_range = 0.0;
  options.max_range = 100.0;
  options.free_range = 5.0;
  return options;
}

inline PointScan project(const LaserScan& scan, const ProjectionOptions& options = plain(),
                         const Eigen::Isometry3d& base_from_laser = Eigen::Isometry3d::Identity(),
                         const Pose2& motion = {}) {
  return project_scan(scan, base_from_laser, motion, options);
}

inline PointScan scan_of_room(std::size_t beams, double field_of_view = 4.5) {
  LaserScan scan = sweep(beams, field_of_view);
  measure(scan, Eigen::Isometry3d::Identity());
  return project(scan);
}

}  // namespace matchbox_slam
