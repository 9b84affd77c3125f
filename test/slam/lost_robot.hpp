#pragma once

#include <memory>
#include <utility>

#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {

/// Half a minute in rooms with perfect sensors, in the map's frame.
[[nodiscard]] inline SimulatedRun perfect_drive() {
  SimulationOptions options;
  options.laser.scan_rate = 5.0;
  options.laser.beams = 260;
  options.time.duration = 30.0;
  const World world = make_world("rooms", 3);
  return simulate_run(world, world.route(), without_noise(options), 3);
}

/// The map of a drive, each scan where the truth is.
[[nodiscard]] inline EngineState map_of(const SimulatedRun& run) {
  SlamEngine engine({}, std::make_shared<OdometryOnlyMatcher>(), 1, run.world_from_base.front());
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    engine.process(scan_input(run, i));
  }
  return engine.snapshot();
}

/// The map, with a robot that has just got lost: it believes to be there, in a new component.
[[nodiscard]] inline EngineState lost_in(EngineState start, const Pose2& active_from_base) {
  const EngineOptions options;
  start.begin_anew(active_from_base, 0.01 * Eigen::Matrix3d::Identity());
  start.localization.components.push_back({SlamMap(options.map, options.field), {}, {}, 0.0});
  start.localization.active = start.localization.components.size();
  return start;
}

}  // namespace matchbox_slam
