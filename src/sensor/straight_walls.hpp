#pragma once

#include <vector>

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// Standard deviation of the ranges of neighbouring hits about a smooth surface [m]: how far each
/// hit lies, along its beam, from the line through its two neighbours. Hits that lie much farther
/// off than the others, as at corners and edges, do not count. 0 when there are too few.
[[nodiscard]] double range_noise(const std::vector<ScanPoint>& points, double max_wall_gap);

/// Cuts the scan into straight walls, as far as a straight wall explains the hits within their
/// noise, and moves each hit along its beam onto its wall, whose normal it gets. Hits that are part
/// of no such wall, and those too far off it, stay where they are, with a normal of zero. The walls
/// are lines of least squares of the ranges: a grazing beam tells a wall's place much better than
/// one that meets it head on. Where a full circle begins and ends, a wall is taken for two. Cost:
/// linear in the number of points.
void straighten_walls(std::vector<ScanPoint>& points, double noise, double max_wall_gap);

}  // namespace matchbox_slam
