#pragma once

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// The share of a scan's beams, by the length of wall that their points stand for, that at this
/// pose cross a wall of the map clearly before they end: 0.4 m or more before, and not along it.
/// 0...1; a scan without points violates nothing. What the score cannot tell: a wrong pose may
/// fit as well as a right one in a place that is new, but there its beams pass through walls.
/// Beams without return do not count: glass has them too.
/// Cost: of some 300 beams at most, spread evenly, a look-up about every 0.3 m.
[[nodiscard]] double free_space_violation(const PointScan& scan, const Pose2& map_from_base,
                                          const LikelihoodField& field);

/// The share of a scan, by the length of wall that it stands for, that lies on walls which were
/// seen from their other side alone: both sides look alike to the score, and are a wall's thickness
/// apart. 0...1. Cost: two look-ups a point.
[[nodiscard]] double share_on_other_sides(const PointScan& scan, const Pose2& map_from_base,
                                          const LikelihoodField& field);

}  // namespace matchbox_slam
