#pragma once

#include "matchbox_slam/map/scan_inserter.hpp"

namespace matchbox_slam {

/// Draws a scan as insert_scan does, but into the occupancy grid alone.
void draw_occupancy(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                    MapUse use, InsertionMemory& memory, OccupancyGrid& occupancy);

}  // namespace matchbox_slam
