#include "slam/scan_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kViewSectors = 180;  // of 2 degrees, as lasers have a beam a degree and more
constexpr float kNever = std::numeric_limits<float>::infinity();

std::size_t sector_of(const Eigen::Vector2d& direction) {
  const double turns = (std::atan2(direction.y(), direction.x()) + kPi) / (2.0 * kPi);
  return std::min(kViewSectors - 1, static_cast<std::size_t>(turns * kViewSectors));
}

Eigen::Vector2d laser_of(const PointScan& scan) {
  if (!scan.points.empty()) {
    return scan.points.front().origin;
  }
  return scan.free_rays.empty() ? Eigen::Vector2d::Zero().eval() : scan.free_rays.front().origin;
}

}  // namespace

ScanView::ScanView(const PointScan& scan, const Pose2& map_from_base)
    : reaches_(kViewSectors, {kNever, -kNever}) {
  const Eigen::Vector2d laser = laser_of(scan);
  map_from_laser_ = map_from_base * Pose2{laser.x(), laser.y(), 0.0};
  const auto see = [&](const Eigen::Vector2d& end) {
    const Eigen::Vector2d way = end - laser;
    if (!way.allFinite()) {
      return;
    }
    Reach& reach = reaches_[sector_of(way)];
    const auto range = static_cast<float>(way.norm());
    reach.nearest = std::min(reach.nearest, range);
    reach.farthest = std::max(reach.farthest, range);
  };
  for (const ScanPoint& point : scan.points) {
    see(point.position);
  }
  for (const FreeRay& ray : scan.free_rays) {
    see(ray.end);
  }
}

ScanView::Look ScanView::at(const Eigen::Vector2d& place) const {
  // [m] between what is the same, as seen from a little elsewhere.
  constexpr double kViewTolerance = 0.2;
  const Eigen::Vector2d way = map_from_laser_.inverse() * place;
  const Reach& reach = reaches_[sector_of(way)];
  const double range = way.norm();
  if (reach.farthest < 0.0F) {
    return Look::kNone;
  }
  if (range > reach.farthest + kViewTolerance) {
    return Look::kBlocked;
  }
  return range < reach.nearest - kViewTolerance ? Look::kThrough : Look::kHit;
}

}  // namespace matchbox_slam
