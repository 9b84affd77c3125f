#pragma once

#include <cstddef>

#include "matchbox_slam/slam/key_scans.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {

/// Key scans a metre apart through rooms.
[[nodiscard]] inline PlacedScans drive_through_rooms(std::size_t scans) {
  LaserOptions laser;
  laser.beams = 90;
  const World world = make_rooms_world(3);
  const RobotMotion motion = drive(world.route(), {});
  KeyScans keys;
  for (std::size_t i = 0; i < scans; ++i) {
    const Pose2 pose = motion.pose(4.0 + 2.0 * static_cast<double>(i));
    keys.add(MeasuredScan{ideal_scan(world, laser, pose), laser.base_from_laser(), {}, {}}, 0,
             pose);
  }
  return keys.all();
}

}  // namespace matchbox_slam
