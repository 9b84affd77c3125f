#pragma once

#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/map_parts.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"

namespace matchbox_slam {

/// Whether a scan goes into the part of the map that the robot is in: only what was matched without
/// a doubt and shows something new, except for what starts a map. A further laser's first scan may
/// show what no other has seen yet: then it goes where the others have just put the base.
/// @param was_matched  the scan before.
[[nodiscard]] bool is_to_be_inserted(const ScanInput& input, const ScanOutcome& outcome,
                                     const MapParts& parts, bool was_matched,
                                     const SlamOptions& options);

/// map_from_base of a scan that has waited: about where it is said to be; where the map holds it,
/// that knows better. None where its beams would go through walls of the map, as of one that was
/// seen while the robot was carried.
[[nodiscard]] std::optional<Pose2> placed_best(const PointScan& scan, const Pose2& map_from_base,
                                               const SlamMap& map, const DoubtOptions& options);

}  // namespace matchbox_slam
