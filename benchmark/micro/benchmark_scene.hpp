#pragma once

#include <vector>

#include "matchbox_slam/sensor/laser_scan.hpp"
#include "matching/match_scene.hpp"
#include "simulation/laser.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// The simulated office in which everything is timed; its seed is fixed.
[[nodiscard]] const World& benchmark_world();

/// The PR2's laser with another number of beams.
[[nodiscard]] LaserOptions laser_of(int beams);

/// A map and a scan amid the office, made once for each number of beams.
[[nodiscard]] const MatchScene& benchmark_scene(int beams);

/// That scan as the laser measured it.
[[nodiscard]] LaserScan benchmark_scan(int beams);

/// A scan and where it was taken.
struct LocatedPoints {
  PointScan scan;
  Pose2 map_from_base;
};

/// Scans from poses spread evenly over the first part of the route.
/// @param duration  of that part [s].
[[nodiscard]] std::vector<LocatedPoints> scans_along_route(int beams, double duration, int count);

/// Numbers of beams from a small safety laser to more than any planar laser has.
inline constexpr int kFewestBeams = 100;
inline constexpr int kCommonBeams = 1040;
inline constexpr int kMostBeams = 10000;

}  // namespace matchbox_slam
