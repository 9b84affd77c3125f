#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "simulation/wall_segment.hpp"

namespace matchbox_slam {

/// From one range to another [m].
struct RayPart {
  double from = 0.0;
  double to = std::numeric_limits<double>::infinity();
};

/// A uniform grid of buckets that holds, for each square cell, the segments that touch it, so that
/// a ray is tested against few of them. Those that move are not in it. The cells along a ray are
/// visited in order (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing",
/// Eurographics 1987).
class SegmentGrid {
 public:
  struct Hit {
    double range = 0.0;  ///< [m]
    std::size_t segment = 0;
  };

  explicit SegmentGrid(const std::vector<WallSegment>& segments);

  /// The first of `segments` that the ray meets up to `max_range` and that does not let it pass.
  /// They are the ones that the grid was built of; it keeps only their numbers.
  /// @param at_tables  part of the ray [m] on which it is low enough to meet tables.
  /// @param chance     of this ray, where surfaces leave to chance what passes them.
  [[nodiscard]] std::optional<Hit> first_hit(const std::vector<WallSegment>& segments,
                                             const Eigen::Vector2d& origin,
                                             const Eigen::Vector2d& direction, double max_range,
                                             const RayPart& at_tables, std::uint64_t chance) const;

 private:
  [[nodiscard]] bool touches(const WallSegment& segment, int column, int row) const;
  [[nodiscard]] std::size_t index_of(int column, int row) const;
  [[nodiscard]] int cell_of(double coordinate, double low, int cells) const;

  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_ = Eigen::Vector2d::Zero();
  double cell_size_ = 1.0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::size_t> first_in_cell_;  ///< into in_cells_, one more than there are cells
  std::vector<std::size_t> in_cells_;
};

}  // namespace matchbox_slam
