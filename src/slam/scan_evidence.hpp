#pragma once

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"

namespace matchbox_slam {

/// The log-likelihood ratio of a scan at a pose in a map that counts hits and passes. Each beam
/// passes cells, where walls would have stopped it, and ends in or near one that reflects or does
/// not; what is unknown says nothing, nor does the other side of a wall. (The beam model of
/// reflection maps; Hähnel, Burgard and Thrun 2003.) Each beam is limited, as it may have met what
/// was not there before.
///
/// Beams that see one surface side by side are one witness: a scan counts as so many as half metres
/// of wall that it sees, and as beams that are farther apart. Beams without return say nothing:
/// glass has them, too. Cost: of some 180 beams, spread evenly, a look-up about every 0.3 m.
/// @param map  with its field rendered.
[[nodiscard]] ScanEvidence evidence_of(const PointScan& scan, const Pose2& map_from_base,
                                       const SlamMap& map);

/// Whether so little of a scan fits what is known where it ends that it may be of elsewhere.
[[nodiscard]] bool is_badly_explained(const ScanEvidence& evidence);

}  // namespace matchbox_slam
