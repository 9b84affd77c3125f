#include "simulation/wall_segment.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

// Lets a ray through the common end of two segments hit at least one of them despite rounding.
constexpr double kEndTolerance = 1e-9;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool are_crossing(const WallSegment& a, const WallSegment& b) {
  const Eigen::Vector2d along_a = a.end - a.start;
  const Eigen::Vector2d along_b = b.end - b.start;
  return cross(along_a, b.start - a.start) * cross(along_a, b.end - a.start) < 0.0 &&
         cross(along_b, a.start - b.start) * cross(along_b, a.end - b.start) < 0.0;
}

}  // namespace

std::optional<double> intersect_ray(const WallSegment& segment, const Eigen::Vector2d& origin,
                                    const Eigen::Vector2d& direction) {
  const Eigen::Vector2d along = segment.end - segment.start;
  const Eigen::Vector2d to_start = segment.start - origin;
  const double denominator = cross(direction, along);
  if (denominator == 0.0) {
    return std::nullopt;
  }
  const double fraction = cross(to_start, direction) / denominator;
  const double range = cross(to_start, along) / denominator;
  if (range < 0.0 || fraction < -kEndTolerance || fraction > 1.0 + kEndTolerance) {
    return std::nullopt;
  }
  return range;
}

bool lets_pass(const WallSegment& segment, const Eigen::Vector2d& direction, std::uint64_t chance) {
  const WallSurface& surface = segment.surface;
  if (surface.passing > 0.0 && Random(chance).uniform() < surface.passing) {
    return true;
  }
  return surface.widest_incidence < 0.5 * kPi &&
         std::abs(segment.normal().dot(direction)) < std::cos(surface.widest_incidence);
}

double depth_of_return(const WallSegment& segment, std::uint64_t chance) {
  const double depth = segment.surface.depth;
  return depth > 0.0 ? depth * Random(chance).uniform() : 0.0;
}

double distance(const WallSegment& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d along = segment.end - segment.start;
  const double fraction = (point - segment.start).dot(along) / along.squaredNorm();
  return (segment.start + std::clamp(fraction, 0.0, 1.0) * along - point).norm();
}

double distance(const WallSegment& a, const WallSegment& b) {
  if (are_crossing(a, b)) {
    return 0.0;
  }
  return std::min(
      {distance(a, b.start), distance(a, b.end), distance(b, a.start), distance(b, a.end)});
}

}  // namespace matchbox_slam
