#include "simulation/simulated_run.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/interrupted.hpp"
#include "matchbox_slam/common/random.hpp"
#include "simulation/kidnapped_motion.hpp"
#include "simulation/scan_faults.hpp"

namespace matchbox_slam {
namespace {

// Each source of chance has its own stream, so that changing one leaves the others as they were.
enum Stream : std::uint64_t {
  kLaserStream = 1,
  kOdometryStream,
  kFaultTimes,
  kKidnaps,
  kJumps,
  kPeople,
  kSecondLaserStream
};

LaserOptions mounted(LaserOptions laser, const Pose2& base_from_laser) {
  laser.mount_x = base_from_laser.x;
  laser.mount_y = base_from_laser.y;
  laser.mount_yaw = base_from_laser.theta;
  return laser;
}

/// Stamps at a rate [Hz] from `start` on, the last at or after `end`.
std::vector<double> stamps_at_rate(double start, double end, double rate) {
  std::vector<double> stamps = {start};
  while (stamps.back() < end) {
    stamps.push_back(start + static_cast<double>(stamps.size()) / rate);
  }
  return stamps;
}

void append(std::vector<LaserScan> more, std::vector<LaserScan>& scans) {
  std::move(more.begin(), more.end(), std::back_inserter(scans));
}

}  // namespace

SimulatedRun simulate_run(const World& world, const Route& route, const SimulationOptions& options,
                          std::uint64_t seed, const std::function<bool()>& is_interrupted) {
  check_laser_options(options.laser);
  const RobotMotion motion = drive(route, options.drive);
  const double start = options.time.start_stamp;
  const double duration = options.time.duration > 0.0 ? options.time.duration : motion.duration();
  SimulatedRun run;
  run.faults = with_drawn_times(options.faults, duration, mix_seed(seed, kFaultTimes));
  const KidnappedMotion kidnapped(motion, run.faults, mix_seed(seed, kKidnaps));
  const PoseAtTime world_from_base = [&](double stamp) { return kidnapped.pose(stamp - start); };
  run.base_from_laser = options.laser.base_from_laser();
  LaserOptions second;
  if (options.second_laser) {
    second = mounted(options.laser, options.second_laser->base_from_laser);
    run.base_from_second =
        mounted(options.laser, options.second_laser->tf_base_from_laser).base_from_laser();
  }
  const std::vector<double> scan_stamps =
      stamps_at_rate(start, start + duration, options.laser.scan_rate);
  run.scans.reserve(scan_stamps.size());
  run.world_from_base.reserve(scan_stamps.size());
  for (std::size_t i = 0; i < scan_stamps.size(); ++i) {
    if (is_interrupted && is_interrupted()) {
      throw Interrupted("interrupted; nothing is written");
    }
    const double stamp = scan_stamps[i];
    if (is_any_on(FaultKind::kDropout, stamp - start, run.faults)) {
      continue;
    }
    const auto measure = [&](const LaserOptions& laser, Stream stream) {
      const std::uint64_t scan_seed = mix_seed(mix_seed(seed, stream), i);
      LaserScan scan = simulate_scan(world, laser, world_from_base, stamp, scan_seed).scan;
      add_scan_faults(stamp - start, run.faults, mix_seed(seed, kPeople), scan);
      return in_parts(scan, laser);
    };
    append(measure(options.laser, kLaserStream), run.scans);
    if (options.second_laser) {
      append(measure(second, kSecondLaserStream), run.second_scans);
    }
    while (run.world_from_base.size() < run.scans.size()) {
      run.world_from_base.push_back(world_from_base(run.scans[run.world_from_base.size()].stamp));
    }
  }
  if (run.scans.empty()) {
    throw ConfigurationError("the faults leave no scan of the run; give them less time");
  }
  const double sweep = options.laser.time_increment * (options.laser.beams - 1);
  const std::vector<double> odometry_stamps =
      stamps_at_rate(start, scan_stamps.back() + sweep, options.odometry.odometry_rate);
  run.odometry = with_odometry_faults(
      simulate_odometry([&](double stamp) { return kidnapped.pose_on_wheels(stamp - start); },
                        odometry_stamps, options.odometry, mix_seed(seed, kOdometryStream)),
      run.faults, start, mix_seed(seed, kJumps));
  return run;
}

}  // namespace matchbox_slam
