#include "simulation/odometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// The shares by which distances and turns are off that wander along the way.
struct Wander {
  double translation = 0.0;
  double rotation = 0.0;
};

/// @param way  [m] driven and [rad] turned so far, together.
Wander wander_at(double way, const OdometryOptions& options, std::uint64_t seed) {
  // Chance of its own, so that the noise stays what it is without it.
  Random random(mix_seed(mix_seed(seed, 0x77616E646572ULL), static_cast<std::uint64_t>(way)));
  const double translation = options.translation_wander * random.gaussian();
  return {translation, options.rotation_wander * random.gaussian()};
}

/// What the wheels report of a true motion, both in the robot's frame before it.
Pose2 measure_motion(const Pose2& motion, const OdometryOptions& options, const Wander& wander,
                     Random& random) {
  const double distance = std::hypot(motion.x, motion.y);
  const double turn = std::abs(motion.theta);
  const double distance_error = (options.translation_bias + wander.translation) * distance +
                                options.translation_noise * std::sqrt(distance) * random.gaussian();
  const double turn_noise = options.rotation_noise * std::sqrt(turn) * random.gaussian();
  const double heading_noise = options.heading_noise * std::sqrt(distance) * random.gaussian();
  const double scale = distance > 0.0 ? 1.0 + distance_error / distance : 1.0;
  const double theta = motion.theta * (1.0 + (options.rotation_bias + wander.rotation)) +
                       options.heading_bias * distance + turn_noise + heading_noise;
  return {scale * motion.x, scale * motion.y, wrap_angle(theta)};
}

/// What is told of a motion from `since_start` on.
Pose2 with_slip(Pose2 motion, double since_start, const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    if (!fault.is_on(since_start)) {
      continue;
    }
    if (fault.kind == FaultKind::kEncoders) {
      return {};
    }
    const double share = 1.0 + fault.amount;
    if (fault.kind == FaultKind::kHeadingSlip) {
      motion.theta *= share;
    } else if (fault.kind == FaultKind::kWaySlip) {
      motion = {share * motion.x, share * motion.y, motion.theta};
    }
  }
  return motion;
}

/// The jumps from one time on until just before another [s since the start].
Pose2 jump_between(double from, double to, const std::vector<Fault>& faults, std::uint64_t seed) {
  Pose2 jump;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const Fault& fault = faults[i];
    if (fault.time < from || fault.time >= to) {
      continue;
    }
    if (fault.kind == FaultKind::kJump) {
      const double direction = Random(mix_seed(seed, i)).uniform(-kPi, kPi);
      jump =
          jump * Pose2{fault.amount * std::cos(direction), fault.amount * std::sin(direction), 0.0};
    } else if (fault.kind == FaultKind::kTurnJump) {
      jump = jump * Pose2{0.0, 0.0, fault.amount};
    }
  }
  return jump;
}

}  // namespace

std::vector<OdometryReading> simulate_odometry(const PoseAtTime& world_from_base,
                                               const std::vector<double>& stamps,
                                               const OdometryOptions& options, std::uint64_t seed) {
  Random random(seed);
  std::vector<OdometryReading> readings;
  readings.reserve(stamps.size());
  Pose2 odom_from_base;
  Pose2 world_from_last;
  double way = 0.0;
  for (const double stamp : stamps) {
    const Pose2 world_from_now = world_from_base(stamp);
    if (!readings.empty()) {
      const Pose2 motion = world_from_last.inverse() * world_from_now;
      const Wander wander = wander_at(way, options, seed);
      odom_from_base = odom_from_base * measure_motion(motion, options, wander, random);
      way += std::hypot(motion.x, motion.y) + std::abs(motion.theta);
    }
    world_from_last = world_from_now;
    readings.push_back({stamp, odom_from_base});
  }
  return readings;
}

std::vector<OdometryReading> with_odometry_faults(const std::vector<OdometryReading>& readings,
                                                  const std::vector<Fault>& faults, double start,
                                                  std::uint64_t seed) {
  if (faults.empty() || readings.empty()) {
    return readings;
  }
  std::vector<OdometryReading> told = {readings.front()};
  Pose2 odom_from_base = readings.front().odom_from_base;  // as it would be told without kFreeze
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const OdometryReading& before = readings[i - 1];
    const double from = before.stamp - start;
    const double now = readings[i].stamp - start;
    const Pose2 motion = before.odom_from_base.inverse() * readings[i].odom_from_base;
    odom_from_base =
        odom_from_base * with_slip(motion, from, faults) * jump_between(from, now, faults, seed);
    told.push_back({readings[i].stamp, is_any_on(FaultKind::kFreeze, now, faults)
                                           ? told.back().odom_from_base
                                           : odom_from_base});
  }
  return told;
}

}  // namespace matchbox_slam
