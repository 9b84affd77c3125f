#pragma once

#include <cstdint>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "simulation/fault.hpp"
#include "simulation/laser.hpp"

namespace matchbox_slam {

/// Errors of the wheels' odometry. Noise is white over the distance: its variance grows in
/// proportion to the way driven or turned, and the deviation given is that after 1 m or 1 rad. What
/// wanders is a share that stays for some way, as wheels on a carpet have it. The
/// defaults are a decent wheeled robot's; over 100 m they add up to metres.
struct OdometryOptions {
  double odometry_rate = 50.0;
  double translation_noise = 0.02;
  double rotation_noise = 0.03;
  double heading_noise = 0.008;
  double translation_bias = 0.01;
  double rotation_bias = 0.01;
  double heading_bias = 0.003;
  double translation_wander = 0.0;
  double rotation_wander = 0.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.odometry_rate, "odometry_rate", between(1.0, 1e3), "Hz", "Readings a second.");
    option(self.translation_noise, "translation_noise", between(0.0, 1.0), "m/sqrt(m)",
           "Standard deviation of the distance after one metre.");
    option(self.rotation_noise, "rotation_noise", between(0.0, 1.0), "rad/sqrt(rad)",
           "Standard deviation of the heading after turning one radian.");
    option(self.heading_noise, "heading_noise", between(0.0, 1.0), "rad/sqrt(m)",
           "Standard deviation of the heading after driving one metre.");
    option(self.translation_bias, "translation_bias", between(-0.5, 0.5), "m/m",
           "Share by which every distance is reported too long.");
    option(self.rotation_bias, "rotation_bias", between(-0.5, 0.5), "rad/rad",
           "Share by which every turn is reported too large.");
    option(self.heading_bias, "heading_bias", between(-0.5, 0.5), "rad/m",
           "Turn that is reported for every metre driven straight on.");
    option(self.translation_wander, "translation_wander", between(0.0, 0.5), "m/m",
           "Standard deviation of the share by which distances are off for a metre or radian of "
           "the way, and by another for the next.");
    option(self.rotation_wander, "rotation_wander", between(0.0, 0.5), "rad/rad",
           "Likewise of turns.");
  }
};

/// Where the odometry believes the base to be.
struct OdometryReading {
  double stamp = 0.0;  ///< [s]
  Pose2 odom_from_base;
};

/// Integrates the true motion between `stamps`, with errors, in the robot's own frame. The first
/// reading is the origin of the odometry frame. The same seed gives the same bits.
/// @param stamps  [s], ascending.
[[nodiscard]] std::vector<OdometryReading> simulate_odometry(const PoseAtTime& world_from_base,
                                                             const std::vector<double>& stamps,
                                                             const OdometryOptions& options,
                                                             std::uint64_t seed);

/// The readings that are told instead when the odometry has faults: it stands still, slips or
/// jumps.
/// @param readings  without faults.
/// @param start     stamp at which the faults' times begin [s].
/// @param seed      of the directions of jumps.
[[nodiscard]] std::vector<OdometryReading> with_odometry_faults(
    const std::vector<OdometryReading>& readings, const std::vector<Fault>& faults, double start,
    std::uint64_t seed);

}  // namespace matchbox_slam
