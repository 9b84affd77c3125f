#pragma once

#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// Appends what each hit of a scan shows of the surfaces around.
void add_surfaces_at_hits(const PointScan& scan, const Pose2& map_from_base,
                          std::vector<SurfaceHit>& hits);
[[nodiscard]] std::vector<SurfaceHit> surfaces_at_hits(const PointScan& scan,
                                                       const Pose2& map_from_base);

/// Appends points on the walls that go on from hit to hit, without the hits themselves: far away
/// the beams are wider apart than cells.
/// @param spacing  of the points, at most [m].
void add_surfaces_between_hits(const PointScan& scan, const Pose2& map_from_base, double spacing,
                               std::vector<SurfaceHit>& wall);
[[nodiscard]] std::vector<SurfaceHit> surfaces_between_hits(const PointScan& scan,
                                                            const Pose2& map_from_base,
                                                            double spacing);

}  // namespace matchbox_slam
