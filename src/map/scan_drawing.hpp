#pragma once

#include "matchbox_slam/map/scan_inserter.hpp"

namespace matchbox_slam {

// Parts of insert_scan, for maps of which not everything is looked at.

/// Draws a scan into the occupancy grid alone.
void draw_occupancy(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                    InsertionMemory& memory, OccupancyGrid& occupancy);

/// As insert_unrendered, but for the reflections, which are not counted.
void insert_uncounted(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                      SlamMap& map);

}  // namespace matchbox_slam
