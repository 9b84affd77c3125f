#include "simulation/world.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace matchbox_slam {
namespace {

std::vector<WallSegment> checked(std::vector<WallSegment> segments) {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!segments[i].start.allFinite() || !segments[i].end.allFinite() ||
        !(segments[i].length() > 0.0)) {
      throw std::invalid_argument("wall segment " + std::to_string(i) + " has length " +
                                  std::to_string(segments[i].length()) +
                                  "; it must be finite and above 0");
    }
  }
  return segments;
}

}  // namespace

World::World(std::vector<WallSegment> segments, Route route)
    : segments_(checked(std::move(segments))), route_(std::move(route)), grid_(segments_) {}

std::optional<RayHit> World::cast_ray(const Eigen::Vector2d& origin,
                                      const Eigen::Vector2d& direction, double max_range,
                                      const RayPart& at_tables) const {
  const std::optional<SegmentGrid::Hit> hit =
      grid_.first_hit(segments_, origin, direction, max_range, at_tables);
  if (!hit) {
    return std::nullopt;
  }
  const Eigen::Vector2d normal = segments_[hit->segment].normal();
  return RayHit{hit->range, hit->segment, normal.dot(direction) > 0.0 ? -normal : normal};
}

}  // namespace matchbox_slam
