#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"
#include "simulation/fault.hpp"
#include "simulation/laser.hpp"
#include "simulation/odometry.hpp"
#include "simulation/robot.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// When a run starts and how long it lasts.
struct RunTimeOptions {
  double duration = 0.0;
  double start_stamp = 1327500000.0;  // 25 January 2012, when the Stata bags were recorded

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.duration, "duration", between(0.0, 1e4), "s",
           "Length of the run; at the end of the route the robot rests. 0: until the route ends.");
    option(self.start_stamp, "start_stamp", between(1.0, 4e9), "s",
           "Stamp of the first scan, in seconds since 1970.");
  }
};

/// A laser beside the first, of the same kind and at the same height.
struct SecondLaserOptions {
  Pose2 base_from_laser;
  Pose2 tf_base_from_laser;  ///< as tf says, which may be wrong
};

/// All options of a run.
struct SimulationOptions {
  LaserOptions laser;
  DriveOptions drive;
  OdometryOptions odometry;
  RunTimeOptions time;
  std::vector<Fault> faults;  ///< those whose times are random get theirs by the seed
  std::optional<SecondLaserOptions> second_laser;
};

/// All that the sensors of a robot told on its way, and the truth.
struct SimulatedRun {
  Eigen::Isometry3d base_from_laser = Eigen::Isometry3d::Identity();
  std::vector<LaserScan> scans;
  Eigen::Isometry3d base_from_second = Eigen::Isometry3d::Identity();  ///< as tf says
  std::vector<LaserScan> second_scans;    ///< one with each scan, where there is a second laser
  std::vector<Pose2> world_from_base;     ///< truth at the stamp of each scan
  std::vector<OdometryReading> odometry;  ///< from the first scan's stamp to after the last beam
  std::vector<Fault> faults;              ///< what went wrong, with its times
};

/// Drives the route through the world. The same seed gives the same bits.
/// Throws ConfigurationError for laser options that do not fit together and std::invalid_argument
/// for a route that cannot be driven, and Interrupted when `is_interrupted` says so.
[[nodiscard]] SimulatedRun simulate_run(const World& world, const Route& route,
                                        const SimulationOptions& options, std::uint64_t seed,
                                        const std::function<bool()>& is_interrupted = {});

}  // namespace matchbox_slam
