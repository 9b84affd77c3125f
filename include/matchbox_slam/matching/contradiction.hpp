#pragma once

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// The share of a scan's beams, by the length of wall that their points stand for, that at this
/// pose cross a wall of the map clearly before they end: 0.4 m or more before, and not along it.
/// 0...1; a scan without points contradicts nothing. What the score cannot tell: a wrong pose may
/// fit as well as a right one in a place that is new, but there its beams pass through walls.
/// Beams without return do not count: glass has them too.
/// Cost: of some 300 beams at most, spread evenly, a look-up about every 0.3 m.
[[nodiscard]] double contradiction(const PointScan& scan, const Pose2& map_from_base,
                                   const LikelihoodField& field);

/// A scan without the points that lie on the back of a wall at this pose, and without its rays: the
/// map is free behind them, and not in front, where their beams came from. Both sides of a wall
/// look alike to the score, and are a wall's thickness apart. Cost: three look-ups a point.
[[nodiscard]] PointScan without_backs(const PointScan& scan, const Pose2& map_from_base,
                                      const OccupancyGrid& occupancy, const LikelihoodField& field);

/// Share of a scan, by the length of wall that it stands for, that lies on backs of walls.
[[nodiscard]] double share_on_backs(const PointScan& scan, const Pose2& map_from_base,
                                    const OccupancyGrid& occupancy, const LikelihoodField& field);

}  // namespace matchbox_slam
