#include "map/scan_surfaces.hpp"

#include <cmath>
#include <cstddef>

#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {

void add_surfaces_at_hits(const PointScan& scan, const Pose2& map_from_base,
                          std::vector<SurfaceHit>& hits) {
  const Transform2 to_map(map_from_base);
  for (const ScanPoint& point : scan.points) {
    hits.push_back({to_map * point.position, to_map.turned(point.normal)});
  }
}

std::vector<SurfaceHit> surfaces_at_hits(const PointScan& scan, const Pose2& map_from_base) {
  std::vector<SurfaceHit> hits;
  hits.reserve(scan.points.size());
  add_surfaces_at_hits(scan, map_from_base, hits);
  return hits;
}

void add_surfaces_between_hits(const PointScan& scan, const Pose2& map_from_base, double spacing,
                               std::vector<SurfaceHit>& wall) {
  const Transform2 to_map(map_from_base);
  for (std::size_t i = 0; i + 1 < scan.points.size(); ++i) {
    const ScanPoint& a = scan.points[i];
    const ScanPoint& b = scan.points[i + 1];
    if (!a.joined_to_next) {
      continue;
    }
    const Eigen::Vector2d step = b.position - a.position;
    const int pieces = static_cast<int>(std::ceil(step.norm() / spacing));
    for (int k = 1; k < pieces; ++k) {
      wall.push_back({to_map * Eigen::Vector2d(a.position + step * k / pieces),
                      to_map.turned(2 * k < pieces ? a.normal : b.normal)});
    }
  }
}

std::vector<SurfaceHit> surfaces_between_hits(const PointScan& scan, const Pose2& map_from_base,
                                              double spacing) {
  std::vector<SurfaceHit> wall;
  add_surfaces_between_hits(scan, map_from_base, spacing, wall);
  return wall;
}

}  // namespace matchbox_slam
