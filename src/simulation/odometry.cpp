#include "simulation/odometry.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// What the wheels report of a true motion, both in the robot's frame before it.
Pose2 measure_motion(const Pose2& motion, const OdometryOptions& options, Random& random) {
  const double distance = std::hypot(motion.x, motion.y);
  const double turn = std::abs(motion.theta);
  const double distance_error = options.translation_bias * distance +
                                options.translation_noise * std::sqrt(distance) * random.gaussian();
  const double turn_noise = options.rotation_noise * std::sqrt(turn) * random.gaussian();
  const double heading_noise = options.heading_noise * std::sqrt(distance) * random.gaussian();
  const double scale = distance > 0.0 ? 1.0 + distance_error / distance : 1.0;
  const double theta = motion.theta * (1.0 + options.rotation_bias) +
                       options.heading_bias * distance + turn_noise + heading_noise;
  return {scale * motion.x, scale * motion.y, wrap_angle(theta)};
}

}  // namespace

OdometryOptions without_noise(OdometryOptions options) {
  options.translation_noise = 0.0;
  options.rotation_noise = 0.0;
  options.heading_noise = 0.0;
  options.translation_bias = 0.0;
  options.rotation_bias = 0.0;
  options.heading_bias = 0.0;
  return options;
}

std::vector<OdometryReading> simulate_odometry(const PoseAtTime& world_from_base,
                                               const std::vector<double>& stamps,
                                               const OdometryOptions& options, std::uint64_t seed) {
  Random random(seed);
  std::vector<OdometryReading> readings;
  readings.reserve(stamps.size());
  Pose2 odom_from_base;
  Pose2 world_from_last;
  for (const double stamp : stamps) {
    const Pose2 world_from_now = world_from_base(stamp);
    if (!readings.empty()) {
      const Pose2 motion = world_from_last.inverse() * world_from_now;
      odom_from_base = odom_from_base * measure_motion(motion, options, random);
    }
    world_from_last = world_from_now;
    readings.push_back({stamp, odom_from_base});
  }
  return readings;
}

Pose2 interpolate_odometry(const std::vector<OdometryReading>& odometry, double stamp) {
  if (odometry.empty()) {
    throw std::invalid_argument("there are no odometry readings to interpolate");
  }
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

}  // namespace matchbox_slam
