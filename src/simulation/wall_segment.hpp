#pragma once

#include <Eigen/Core>
#include <optional>

namespace matchbox_slam {

/// A straight piece of wall in the world, without thickness.
struct WallSegment {
  Eigen::Vector2d start;  ///< [m]
  Eigen::Vector2d end;    ///< [m]
  bool is_table = false;  ///< or another thing lower than walls

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

/// Distance between a point and the nearest point of the segment [m].
[[nodiscard]] double distance(const WallSegment& segment, const Eigen::Vector2d& point);

/// Distance between the nearest points of two segments [m], 0 when they cross.
[[nodiscard]] double distance(const WallSegment& a, const WallSegment& b);

}  // namespace matchbox_slam
