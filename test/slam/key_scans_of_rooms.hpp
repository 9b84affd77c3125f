#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/slam/key_scans.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/local_map.hpp"

namespace matchbox_slam {

/// Key scans a metre apart through rooms.
[[nodiscard]] inline PlacedScans drive_through_rooms(std::size_t scans, int beams = 90) {
  LaserOptions laser;
  laser.beams = beams;
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

/// As the graph has it: each one is joined to the newest, by a long way where it is to lie apart.
[[nodiscard]] inline LocalScans local_scans_where(const PlacedScans& keys,
                                                  const std::vector<bool>& is_apart) {
  PoseGraph graph;
  for (std::size_t key = 0; key < keys.size(); ++key) {
    graph.poses.push_back(keys[key].map_from_base);
    if (key + 1 < keys.size()) {
      graph.edges.push_back({key,
                             keys.size() - 1,
                             {is_apart.at(key) ? 100.0 : 1.0, 0.0, 0.0},
                             Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal()});
    }
  }
  const AdjacencyList links(graph);
  return local_scans(keys, {graph, links, keys.size() - 1}, 0.5);
}

}  // namespace matchbox_slam
