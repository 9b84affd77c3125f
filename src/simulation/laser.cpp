#include "simulation/laser.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

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

/// By up to `amplitude` to either side.
double swing(double amplitude, double stamp, double period, double phase) {
  return amplitude * std::sin(2.0 * kPi * stamp / period + phase);
}

/// Part of a ray on which it is no higher than this; its height goes on by `slope`.
RayPart part_below(double limit, double height, double slope) {
  const double range = (limit - height) / slope;
  if (slope < 0.0) {
    return {range, kInfinity};
  }
  return slope > 0.0 ? RayPart{-kInfinity, range}
                     : RayPart{0.0, height <= limit ? kInfinity : -1.0};
}

BeamTruth trace_beam(const World& world, const LaserOptions& options, const Pose2& world_from_base,
                     const Eigen::Isometry3d& ground_from_laser, double angle, double reach,
                     const RayMoment& moment) {
  const Eigen::Vector3d in_base =
      ground_from_laser.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  const double horizontal = in_base.head<2>().norm();
  if (horizontal < 1e-9) {
    return {};  // straight up or down: walls are never met
  }
  const Pose2 turn{0.0, 0.0, world_from_base.theta};
  const Eigen::Vector2d direction = turn * Eigen::Vector2d(in_base.head<2>() / horizontal);
  const Eigen::Vector2d origin =
      world_from_base * Eigen::Vector2d(ground_from_laser.translation().head<2>());
  const double height = ground_from_laser.translation().z();
  const double slope = in_base.z() / horizontal;
  const double floor = options.floor && slope < 0.0 ? -height / slope : kInfinity;
  const std::optional<RayHit> hit =
      world.cast_ray(origin, direction, std::min(floor, reach * horizontal),
                     part_below(options.table_height, height, slope), moment);
  BeamTruth truth;
  if (!hit) {
    truth.range = floor <= reach * horizontal ? floor / horizontal : kInfinity;
    return truth;
  }
  truth.range = hit->range / horizontal;
  truth.segment = hit->segment;
  truth.normal = hit->normal;
  truth.cos_incidence = -hit->normal.dot(direction) * horizontal;
  truth.end = origin + hit->range * direction;
  return truth;
}

/// What small things of which nobody knows leave of the distances: uniform up to what was there.
class Outliers {
 public:
  /// Chance of its own, so that the noise stays what it is without them.
  Outliers(const LaserOptions& options, std::uint64_t seed)
      : options_(options), random_(mix_seed(seed, 0x6F75746C69657273ULL)) {}

  double shortened(double range) {
    if (!(options_.outliers > 0.0)) {
      return range;
    }
    const bool is_one = random_.uniform() < options_.outliers;
    const double before = random_.uniform(options_.range_min, std::min(range, options_.range_max));
    return is_one && before < range ? before : range;
  }

 private:
  const LaserOptions& options_;
  Random random_;
};

/// What a beam reads that tells nothing, as it is lost or the distance too short.
double nothing_told(const LaserOptions& options, double usual) {
  return options.no_return == "zero"  ? 0.0
         : options.no_return == "nan" ? std::numeric_limits<double>::quiet_NaN()
                                      : usual;
}

double measure(double range, const LaserOptions& options) {
  if (range < options.range_min) {
    return nothing_told(options, -kInfinity);
  }
  if (range < options.range_max) {
    return range;
  }
  return options.no_return == "over_range" ? options.range_max + 1.0
                                           : nothing_told(options, kInfinity);
}

/// Of all rays of a scan. Readers of a recording have its stamp but for rounding.
std::uint64_t chance_at(const World& world, double stamp) {
  constexpr double kStampStep = 1e-4;  // [s]
  return mix_seed(world.seed(), static_cast<std::uint64_t>(std::llround(stamp / kStampStep)));
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

Eigen::Isometry3d LaserOptions::nodded(double stamp) const {
  return Eigen::Isometry3d(
      Eigen::AngleAxisd(swing(nod, stamp, 4.0, 0.0), Eigen::Vector3d::UnitY()));
}

Eigen::Isometry3d LaserOptions::rocked(double stamp) const {
  return Eigen::Isometry3d(
      Eigen::AngleAxisd(swing(rock, stamp, 2.3, 1.0), Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(swing(rock, stamp, 3.1, 0.0), Eigen::Vector3d::UnitX()));
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
  if (options.beams % options.parts != 0) {
    throw ConfigurationError("laser: parts is " + std::to_string(options.parts) +
                             "; it must divide the " + std::to_string(options.beams) + " beams");
  }
}

std::vector<BeamTruth> trace_beams(const World& world, const LaserOptions& options,
                                   const PoseAtTime& world_from_base, double stamp) {
  check_laser_options(options);
  const Eigen::Isometry3d mount =
      Eigen::Translation3d(0.0, 0.0, kBaseHeight) * options.base_from_laser();
  const bool sways = options.rock > 0.0 || options.nod > 0.0;
  const auto laser_at = [&](double time) {
    return sways ? options.rocked(time) * mount * options.nodded(time) : mount;
  };
  Eigen::Isometry3d laser = laser_at(stamp);
  // Noise may bring a surface a little out of reach into it.
  const double reach = options.range_max + 10.0 * options.noise_at(options.range_max);
  const std::uint64_t chance = chance_at(world, stamp);
  std::vector<BeamTruth> beams;
  beams.reserve(static_cast<std::size_t>(options.beams));
  Pose2 pose = world_from_base(stamp);
  for (int k = 0; k < options.beams; ++k) {
    const double time = stamp + k * options.time_increment;
    if (options.time_increment > 0.0) {
      pose = world_from_base(time);
      laser = laser_at(time);
    }
    const RayMoment moment{time, mix_seed(chance, static_cast<std::uint64_t>(k))};
    const double angle = first_angle(options) + k * beam_increment(options);
    beams.push_back(trace_beam(world, options, pose, laser, angle, reach, moment));
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
  Outliers outliers(options, seed);
  for (const BeamTruth& beam : result.truth) {
    const double noise =
        options.noise_at(std::min(beam.range, options.range_max)) * random.gaussian();
    const bool is_lost = random.uniform() < options.dropout;
    const double range = is_lost ? nothing_told(options, std::numeric_limits<double>::quiet_NaN())
                                 : measure(outliers.shortened(beam.range) + noise, options);
    scan.ranges.push_back(static_cast<float>(range));
  }
  return result;
}

std::vector<LaserScan> in_parts(const LaserScan& scan, const LaserOptions& options) {
  const std::size_t beams = scan.ranges.size() / static_cast<std::size_t>(options.parts);
  std::vector<LaserScan> parts;
  for (std::size_t first = 0; first < scan.ranges.size(); first += beams) {
    LaserScan part = scan;
    part.stamp += static_cast<double>(first) * scan.time_increment;
    part.angle_min += static_cast<double>(first) * scan.angle_increment;
    const auto begin = scan.ranges.begin() + static_cast<std::ptrdiff_t>(first);
    part.ranges.assign(begin, begin + static_cast<std::ptrdiff_t>(beams));
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace matchbox_slam
