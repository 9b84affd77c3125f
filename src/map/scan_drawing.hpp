#pragma once

#include <cstddef>

#include "matchbox_slam/map/scan_inserter.hpp"

namespace matchbox_slam {

/// Beams of a scan, at most, that say which cells are passed: those side by side say the same, and
/// a thousand of them would take as long as all else together. Some lasers have 361. Half and
/// double were not tried.
constexpr std::size_t kPassingBeams = 400;

/// Draws a scan as insert_scan does, but into the occupancy grid alone.
/// @returns false, and draws nothing, where insert_scan does not.
bool draw_occupancy(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                    MapUse use, InsertionMemory& memory, OccupancyGrid& occupancy);

}  // namespace matchbox_slam
