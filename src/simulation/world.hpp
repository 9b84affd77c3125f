#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "simulation/segment_grid.hpp"
#include "simulation/wall_segment.hpp"

namespace matchbox_slam {

/// Where the robot drives: way-points in the world [m], visited in order.
struct Route {
  double start_heading = 0.0;  ///< [rad], the robot's heading at rest on the first way-point
  std::vector<Eigen::Vector2d> waypoints;
};

/// What a ray met first.
struct RayHit {
  double range = 0.0;       ///< [m] from the ray's origin
  std::size_t segment = 0;  ///< index into World::segments()
  Eigen::Vector2d normal;   ///< unit normal of the surface, towards the ray's origin
};

/// A flat world of straight walls that reflect on both sides, with a route that a robot can drive
/// in it. A value: two worlds of the same segments answer the same.
class World {
 public:
  /// Throws std::invalid_argument for a segment that is not finite or has no length.
  World(std::vector<WallSegment> segments, Route route);

  [[nodiscard]] const std::vector<WallSegment>& segments() const { return segments_; }
  [[nodiscard]] const Route& route() const { return route_; }

  /// The nearest intersection of the ray with a segment, computed exactly, or none up to
  /// `max_range`. Of two segments met at the same range the one with the lower index is taken; a
  /// ray along a segment does not hit it. `direction` has length 1. Cost: the segments near the
  /// ray.
  /// @param at_tables  part of the ray [m] on which it is low enough to meet tables.
  [[nodiscard]] std::optional<RayHit> cast_ray(const Eigen::Vector2d& origin,
                                               const Eigen::Vector2d& direction, double max_range,
                                               const RayPart& at_tables = {}) const;

 private:
  std::vector<WallSegment> segments_;
  Route route_;
  SegmentGrid grid_;
};

}  // namespace matchbox_slam
