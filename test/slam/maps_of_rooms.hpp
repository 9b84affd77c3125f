#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "matchbox_slam/slam/engine_state.hpp"
#include "simulation/laser.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {

/// Where a robot is that drives through the rooms of a seed, every half a metre or so.
[[nodiscard]] inline std::vector<Pose2> way_through_rooms(std::uint64_t seed) {
  const RobotMotion motion = drive(make_rooms_world(seed).route(), {});
  std::vector<Pose2> way;
  for (std::size_t i = 0; i < 100; ++i) {
    way.push_back(motion.pose(4.0 + static_cast<double>(i)));
  }
  return way;
}

/// The map of a robot that saw a world from where it is each second of a motion, with the truth.
[[nodiscard]] inline EngineState map_in(const World& world, const RobotMotion& motion,
                                        std::size_t begin, std::size_t end,
                                        const EngineOptions& options = {},
                                        std::uint64_t noise = 0) {
  LaserOptions laser;
  laser.beams = 180;
  laser.range_noise = 0.01;
  EngineState state{SlamMap(options.map, options.field), {}, {}, {}};
  for (std::size_t i = begin; i < end; ++i) {
    const Pose2 pose = motion.pose(static_cast<double>(i));
    const PoseAtTime at_rest = [&](double /*time*/) { return pose; };
    const double stamp = 1000.0 * static_cast<double>(noise) + static_cast<double>(i);
    LaserScan scan = simulate_scan(world, laser, at_rest, stamp, noise * 1000 + i).scan;
    state.key_scans.add(MeasuredScan{std::move(scan), laser.base_from_laser(), {}, {}}, 0, pose);
  }
  return state;
}

/// The saved map of a robot that saw the rooms of a seed on a part of that way, in a frame of its
/// own, with stamps of its own.
[[nodiscard]] inline EngineState map_of_way(std::uint64_t seed, std::size_t begin, std::size_t end,
                                            const Pose2& map_from_world,
                                            const EngineOptions& options = {}) {
  LaserOptions laser;
  laser.beams = 180;
  laser.range_noise = 0.01;
  const World world = make_rooms_world(seed);
  const std::vector<Pose2> way = way_through_rooms(seed);
  EngineState state{SlamMap(options.map, options.field), {}, {}, {}};
  for (std::size_t i = begin; i < end; ++i) {
    const PoseAtTime at_rest = [&](double /*time*/) { return way[i]; };
    const double stamp = 1000.0 * static_cast<double>(begin) + static_cast<double>(i);
    LaserScan scan = simulate_scan(world, laser, at_rest, stamp, begin * 1000 + i).scan;
    state.key_scans.add(MeasuredScan{std::move(scan), laser.base_from_laser(), {}, {}}, 0,
                        map_from_world * way[i]);
  }
  return state;
}

}  // namespace matchbox_slam
