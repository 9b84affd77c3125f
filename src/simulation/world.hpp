#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "simulation/segment_grid.hpp"
#include "simulation/walk.hpp"
#include "simulation/wall_segment.hpp"

namespace matchbox_slam {

/// Where the robot drives: way-points in the world [m], visited in order.
struct Route {
  double start_heading = 0.0;  ///< [rad], the robot's heading at rest on the first way-point
  std::vector<Eigen::Vector2d> waypoints;
};

/// When a ray is cast.
struct RayMoment {
  double time = 0.0;         ///< [s], which tells where things are that move
  std::uint64_t chance = 0;  ///< of this ray, where surfaces leave to chance what passes them
};

/// What a ray met first.
struct RayHit {
  double range = 0.0;       ///< [m] from the ray's origin, behind the surface where that has depth
  std::size_t segment = 0;  ///< index into World::segments()
  Eigen::Vector2d normal;   ///< unit normal of the surface, towards the ray's origin
};

/// Segments of a world that are one thing, which may stand elsewhere another day.
struct Thing {
  std::size_t begin = 0;                      ///< the first of the segments
  std::size_t end = 0;                        ///< behind the last one
  std::optional<Eigen::Vector2d> hinge = {};  ///< [m] that a door's leaf turns about
};

/// A flat world of straight walls that reflect on both sides, with a route that a robot can drive
/// in it. A value: two worlds of the same segments, walks and seed answer the same.
class World {
 public:
  /// @param segments  those that move where they are at time 0.
  /// @param walks     the ways that segments go.
  /// @param seed      of what surfaces leave to chance.
  /// @param things    which segments are no walls; what moves is none of them.
  /// Throws std::invalid_argument for a segment that is not finite, has no length, or goes a way
  /// that there is not.
  World(std::vector<WallSegment> segments, Route route, std::vector<Walk> walks = {},
        std::uint64_t seed = 0, std::vector<Thing> things = {});

  [[nodiscard]] const std::vector<WallSegment>& segments() const { return segments_; }
  [[nodiscard]] const Route& route() const { return route_; }
  [[nodiscard]] const std::vector<Walk>& walks() const { return walks_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  [[nodiscard]] const std::vector<Thing>& things() const { return things_; }

  /// The nearest intersection of the ray with a segment, computed exactly, or none up to
  /// `max_range` that does not let it pass. Of two segments met at the same range the one with the
  /// lower index is taken; a ray along a segment does not hit it. `direction` has length 1. Cost:
  /// the segments near the ray, and all that move.
  /// @param at_tables  part of the ray [m] on which it is low enough to meet tables.
  [[nodiscard]] std::optional<RayHit> cast_ray(const Eigen::Vector2d& origin,
                                               const Eigen::Vector2d& direction, double max_range,
                                               const RayPart& at_tables = {},
                                               const RayMoment& moment = {}) const;

 private:
  /// The segments that go one way.
  struct Walkers {
    std::vector<std::size_t> segments;
    double reach = 0.0;  ///< [m] from the place on the way
  };

  [[nodiscard]] std::vector<Walkers> walkers() const;

  /// The first of the segments that move, where it is before the `nearest`.
  [[nodiscard]] std::optional<SegmentGrid::Hit> first_moving_hit(const Eigen::Vector2d& origin,
                                                                 const Eigen::Vector2d& direction,
                                                                 double nearest,
                                                                 const RayMoment& moment) const;

  std::vector<WallSegment> segments_;
  Route route_;
  std::vector<Walk> walks_;
  std::uint64_t seed_;
  std::vector<Thing> things_;
  SegmentGrid grid_;
  std::vector<Walkers> walkers_;  ///< one a walk
};

}  // namespace matchbox_slam
