#pragma once

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// How a scan lies on a map, by length of wall.
struct GroundShares {
  double mapped = 0.0;     ///< share of it that lies where something is mapped
  double off_walls = 0.0;  ///< share of that which lies on none of the walls there
};

[[nodiscard]] GroundShares ground_shares(const PointScan& scan, const Pose2& map_from_base,
                                         const SlamMap& map);

/// How well two sets of key scans fit each other where both have seen something: the score of the
/// one on ground that the other has mapped, less the shares of either that the other knows better.
/// Scans that saw a plain corridor from two places of it fit but for what is seen in one of them
/// alone, and no beam has to go through a wall for that. 1 at most.
/// @param score  of `here` against the walls of `there`.
/// Cost: of drawing all of them.
[[nodiscard]] double mutual_fit(const PlacedScans& here, const PlacedScans& there, double score);

}  // namespace matchbox_slam
