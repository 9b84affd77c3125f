#pragma once

#include "lasers/scan_bundle.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"
#include "slam/map_components.hpp"
#include "slam/mapping.hpp"

namespace matchbox_slam {

/// Whether a scan goes into the component of the map that the robot is in: only what was matched
/// and shows something new, except for what starts a map. A secondary laser's first scan may show
/// what no other has seen yet: then it goes where the others have just put the base.
/// @param was_matched  the scan before.
[[nodiscard]] bool is_to_be_inserted(const ScanInput& input, const ScanOutcome& outcome,
                                     const MapComponents& components, bool was_matched,
                                     const SlamOptions& options);

/// Makes a scan and those of the secondary lasers key scans where the outcome has the base; the
/// outcome tells.
/// @param laser  of the primary scan.
void insert(const ScanBundle& bundle, int laser, Mapping& mapping, ScanOutcome& outcome);

/// Whether a scan of a robot that localises is drawn over the map: one that was matched, shows
/// something new, and lies on known ground for the most part. On what it drew outside of the map
/// the robot would follow its own drift, and say that it was sure.
/// @param laser  of the primary scan.
[[nodiscard]] bool is_to_be_drawn_over(const PointScan& scan, int laser, const ScanOutcome& outcome,
                                       const Mapping& mapping);

/// Draws a scan and those of the secondary lasers over the map. See TemporaryMap.
/// @param laser  of the primary scan.
void draw_over(const ScanBundle& bundle, int laser, Mapping& mapping, const ScanOutcome& outcome);

}  // namespace matchbox_slam
