#pragma once

#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// The occupancy as people are to see it. What one scan has seen free counts as unknown, as a
/// single beam may err; but of a robot at rest there is one key scan a laser, and all the others
/// said the same: its scans count twice. As soon as there are more key scans it is the map's own.
/// @param keys  that the map was drawn from.
[[nodiscard]] OccupancyGrid shown_occupancy(const SlamMap& map, const PlacedScans& keys,
                                            const MapOptions& options);

}  // namespace matchbox_slam
