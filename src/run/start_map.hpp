#pragma once

#include <string>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// A saved map and where the robot is in it, as well as one puts a robot on a mark: where it was
/// when the map was saved, or at the configured start in one that does not say. Throws as
/// read_map_start.
[[nodiscard]] MapStart read_start_map(const std::string& path, const SlamSetup& setup);

}  // namespace matchbox_slam
