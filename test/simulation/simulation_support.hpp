#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "matchbox_slam/sensor/scan_input.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"

namespace matchbox_slam {

/// The options with neither noise nor dropouts.
[[nodiscard]] inline LaserOptions without_noise(LaserOptions options) {
  options.range_noise = 0.0;
  options.range_noise_square = 0.0;
  options.dropout = 0.0;
  return options;
}

/// The options with neither noise nor bias.
[[nodiscard]] inline OdometryOptions without_noise(OdometryOptions options) {
  for (double* error : {&options.translation_noise, &options.rotation_noise, &options.heading_noise,
                        &options.translation_bias, &options.rotation_bias, &options.heading_bias,
                        &options.translation_wander, &options.rotation_wander}) {
    *error = 0.0;
  }
  return options;
}

/// The options with perfect sensors: neither noise nor dropouts nor bias nor faults.
[[nodiscard]] inline SimulationOptions without_noise(SimulationOptions options) {
  options.laser = without_noise(options.laser);
  options.odometry = without_noise(options.odometry);
  options.faults.clear();
  return options;
}

/// By their bits, since lost readings are NaN.
[[nodiscard]] inline bool are_same_ranges(const LaserScan& a, const LaserScan& b) {
  return a.ranges.size() == b.ranges.size() &&
         std::memcmp(a.ranges.data(), b.ranges.data(), a.ranges.size() * sizeof(float)) == 0;
}

/// The scan of a robot at rest, without noise and dropouts.
[[nodiscard]] inline LaserScan ideal_scan(const World& world, const LaserOptions& options,
                                          const Pose2& world_from_base, double stamp = 0.0) {
  const PoseAtTime at_rest = [&](double /*time*/) { return world_from_base; };
  return simulate_scan(world, without_noise(options), at_rest, stamp, 0).scan;
}

/// The odometry at any time, interpolated between its readings as tf does. Before the first and
/// after the last it is that one.
[[nodiscard]] inline Pose2 interpolate_odometry(const std::vector<OdometryReading>& odometry,
                                                double stamp) {
  const auto after = std::lower_bound(
      odometry.begin(), odometry.end(), stamp,
      [](const OdometryReading& reading, double time) { return reading.stamp < time; });
  if (after == odometry.end()) {
    return odometry.back().odom_from_base;
  }
  if (after == odometry.begin()) {
    return odometry.front().odom_from_base;
  }
  const auto before = after - 1;
  const double fraction = (stamp - before->stamp) / (after->stamp - before->stamp);
  return interpolate(before->odom_from_base, after->odom_from_base, fraction);
}

/// Along the world's own route.
inline SimulatedRun drive_through(const std::string& world_name, double duration,
                                  std::uint64_t seed, SimulationOptions options = {}) {
  const World world = make_world(world_name, seed);
  options.time.duration = duration;
  return simulate_run(world, world.route(), options, seed);
}

/// One scan of a run as the engine takes it.
[[nodiscard]] inline ScanInput scan_input(const SimulatedRun& run, std::size_t index,
                                          bool with_odometry = true) {
  ScanInput input;
  input.scan = run.scans.at(index);
  input.base_from_laser = run.base_from_laser;
  if (with_odometry) {
    const double stamp = input.scan.stamp;
    input.odometry =
        ScanOdometry{interpolate_odometry(run.odometry, stamp),
                     interpolate_odometry(run.odometry, stamp + input.scan.duration())};
  }
  return input;
}

/// Distance from a point to the nearest wall [m]; infinite in an empty world.
[[nodiscard]] inline double clearance(const World& world, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const WallSegment& segment : world.segments()) {
    nearest = std::min(nearest, distance(segment, point));
  }
  return nearest;
}

/// Length of the lines from way-point to way-point [m].
[[nodiscard]] inline double length_of(const Route& route) {
  double sum = 0.0;
  for (std::size_t i = 1; i < route.waypoints.size(); ++i) {
    sum += (route.waypoints[i] - route.waypoints[i - 1]).norm();
  }
  return sum;
}

/// [m] that were driven.
[[nodiscard]] inline double length_of(const RobotMotion& motion) {
  double sum = 0.0;
  for (const RobotMotion::Step& step : motion.steps()) {
    sum += std::abs(step.speed);
  }
  return sum * motion.duration() / static_cast<double>(motion.steps().size());
}

}  // namespace matchbox_slam
