#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {

/// What beams meet at a piece of wall, and whether it stays where it is. The default is a wall:
/// nothing passes, all returns, and it stands still.
struct WallSurface {
  /// Share of the beams that pass, each by chance, as between the bars of a railing.
  double passing = 0.0;
  /// [rad] off the normal up to which beams return; others pass, as through glass.
  double widest_incidence = 0.5 * kPi;
  /// [m] that beams go on behind it before they return, each by chance from 0 up to this, as in a
  /// hedge.
  double depth = 0.0;
  /// Index into World::walks() of the way that it goes. None: it stands still.
  std::optional<std::size_t> walk;
};

/// Leaves return beams from anywhere in their first decimetres.
/// @param depth    [m]
/// @param passing  share of the beams that pass.
[[nodiscard]] inline WallSurface leaves(double depth, double passing = 0.0) {
  WallSurface surface;
  surface.depth = depth;
  surface.passing = passing;
  return surface;
}

/// A straight piece of wall in the world, without thickness.
struct WallSegment {
  Eigen::Vector2d start;  ///< [m]
  Eigen::Vector2d end;    ///< [m]
  bool is_table = false;  ///< or another thing lower than walls
  WallSurface surface = {};

  [[nodiscard]] double length() const { return (end - start).norm(); }

  /// Unit normal, to the left when going from start to end.
  [[nodiscard]] Eigen::Vector2d normal() const {
    const Eigen::Vector2d along = (end - start).normalized();
    return {-along.y(), along.x()};
  }
};

/// Distance along the ray [m] to its intersection with the segment; none when they do not meet or
/// are parallel. `direction` has length 1.
[[nodiscard]] std::optional<double> intersect_ray(const WallSegment& segment,
                                                  const Eigen::Vector2d& origin,
                                                  const Eigen::Vector2d& direction);

/// Whether a beam passes a segment that it meets.
/// @param chance  decides where the surface leaves it to chance; another for each beam and segment.
[[nodiscard]] bool lets_pass(const WallSegment& segment, const Eigen::Vector2d& direction,
                             std::uint64_t chance);

/// How far [m] behind a segment a beam that does not pass it returns. Chance as for lets_pass.
[[nodiscard]] double depth_of_return(const WallSegment& segment, std::uint64_t chance);

/// Distance between a point and the nearest point of the segment [m].
[[nodiscard]] double distance(const WallSegment& segment, const Eigen::Vector2d& point);

/// Distance between the nearest points of two segments [m], 0 when they cross.
[[nodiscard]] double distance(const WallSegment& a, const WallSegment& b);

}  // namespace matchbox_slam
