#include "simulation/laser.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double beam_increment(const LaserOptions& options) {
  const double spacing = options.field_of_view / options.beams;
  return options.clockwise ? -spacing : spacing;
}

double first_angle(const LaserOptions& options) {
  return options.clockwise ? 0.5 * options.field_of_view : -0.5 * options.field_of_view;
}

BeamTruth trace_beam(const World& world, const Pose2& world_from_base,
                     const Eigen::Isometry3d& base_from_laser, double angle, double reach) {
  const Eigen::Vector3d in_base =
      base_from_laser.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  const double horizontal = in_base.head<2>().norm();
  if (horizontal < 1e-9) {
    return {};  // straight up or down: walls are never met
  }
  const Pose2 turn{0.0, 0.0, world_from_base.theta};
  const Eigen::Vector2d direction = turn * Eigen::Vector2d(in_base.head<2>() / horizontal);
  const Eigen::Vector2d origin =
      world_from_base * Eigen::Vector2d(base_from_laser.translation().head<2>());
  const std::optional<RayHit> hit = world.cast_ray(origin, direction, reach * horizontal);
  if (!hit) {
    return {};
  }
  BeamTruth truth;
  truth.range = hit->range / horizontal;
  truth.segment = hit->segment;
  truth.normal = hit->normal;
  truth.cos_incidence = -hit->normal.dot(direction) * horizontal;
  truth.end = origin + hit->range * direction;
  return truth;
}

double measure(double range, const LaserOptions& options) {
  if (range < options.range_min) {
    return -kInfinity;
  }
  if (range < options.range_max) {
    return range;
  }
  return options.no_return == "infinite" ? kInfinity : options.range_max + 1.0;
}

}  // namespace

Eigen::Isometry3d LaserOptions::base_from_laser() const {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.translation() = Eigen::Vector3d(mount_x, mount_y, mount_z);
  transform.linear() = (Eigen::AngleAxisd(mount_yaw, Eigen::Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(mount_pitch, Eigen::Vector3d::UnitY()) *
                        Eigen::AngleAxisd(mount_roll, Eigen::Vector3d::UnitX()))
                           .toRotationMatrix();
  return transform;
}

void check_laser_options(const LaserOptions& options) {
  if (options.range_min >= options.range_max) {
    throw ConfigurationError("laser: range_min is " + std::to_string(options.range_min) +
                             " m; it must be below range_max, " +
                             std::to_string(options.range_max) + " m");
  }
  const double sweep = options.time_increment * (options.beams - 1);
  if (sweep > 1.0 / options.scan_rate) {
    throw ConfigurationError("laser: time_increment is " + std::to_string(options.time_increment) +
                             " s, so a scan takes " + std::to_string(sweep) +
                             " s; it must fit into the " + std::to_string(1.0 / options.scan_rate) +
                             " s from scan to scan");
  }
}

std::vector<BeamTruth> trace_beams(const World& world, const LaserOptions& options,
                                   const PoseAtTime& world_from_base, double stamp) {
  check_laser_options(options);
  const Eigen::Isometry3d base_from_laser = options.base_from_laser();
  // Noise may bring a surface a little out of reach into it.
  const double reach = options.range_max + 10.0 * options.range_noise;
  std::vector<BeamTruth> beams;
  beams.reserve(static_cast<std::size_t>(options.beams));
  Pose2 pose = world_from_base(stamp);
  for (int k = 0; k < options.beams; ++k) {
    if (options.time_increment > 0.0) {
      pose = world_from_base(stamp + k * options.time_increment);
    }
    const double angle = first_angle(options) + k * beam_increment(options);
    beams.push_back(trace_beam(world, pose, base_from_laser, angle, reach));
  }
  return beams;
}

SimulatedScan simulate_scan(const World& world, const LaserOptions& options,
                            const PoseAtTime& world_from_base, double stamp, std::uint64_t seed) {
  SimulatedScan result;
  result.truth = trace_beams(world, options, world_from_base, stamp);
  LaserScan& scan = result.scan;
  scan.stamp = stamp;
  scan.angle_min = first_angle(options);
  scan.angle_increment = beam_increment(options);
  scan.time_increment = options.time_increment;
  scan.range_min = options.range_min;
  scan.range_max = options.range_max;
  scan.ranges.reserve(result.truth.size());
  Random random(seed);
  for (const BeamTruth& beam : result.truth) {
    const double noise = options.range_noise * random.gaussian();
    const bool is_lost = random.uniform() < options.dropout;
    const double range =
        is_lost ? std::numeric_limits<double>::quiet_NaN() : measure(beam.range + noise, options);
    scan.ranges.push_back(static_cast<float>(range));
  }
  return result;
}

}  // namespace matchbox_slam
