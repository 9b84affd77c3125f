#include "map/scan_surfaces.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

namespace matchbox_slam {

std::vector<SurfaceHit> surfaces_at_hits(const PointScan& scan, const Pose2& map_from_base) {
  const Eigen::Rotation2Dd rotation(map_from_base.theta);
  std::vector<SurfaceHit> hits;
  hits.reserve(scan.points.size());
  for (const ScanPoint& point : scan.points) {
    hits.push_back({map_from_base * point.position, rotation * point.normal});
  }
  return hits;
}

std::vector<SurfaceHit> surfaces_between_hits(const PointScan& scan, const Pose2& map_from_base,
                                              double spacing) {
  const Eigen::Rotation2Dd rotation(map_from_base.theta);
  std::vector<SurfaceHit> wall;
  for (std::size_t i = 0; i + 1 < scan.points.size(); ++i) {
    const ScanPoint& a = scan.points[i];
    const ScanPoint& b = scan.points[i + 1];
    if (!a.joined_to_next) {
      continue;
    }
    const Eigen::Vector2d step = b.position - a.position;
    const int pieces = static_cast<int>(std::ceil(step.norm() / spacing));
    for (int k = 1; k < pieces; ++k) {
      wall.push_back({map_from_base * Eigen::Vector2d(a.position + step * k / pieces),
                      rotation * (2 * k < pieces ? a.normal : b.normal)});
    }
  }
  return wall;
}

}  // namespace matchbox_slam
