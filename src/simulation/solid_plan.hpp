#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "simulation/wall_segment.hpp"

namespace matchbox_slam {

/// A floor that is solid until spaces are cut out of it: corridors, rooms and doors are rectangles
/// along the axes, in steps of 0.1 m, and may overlap. What lies outside it stays solid.
class SolidPlan {
 public:
  /// @param size  [m] from the origin, which is the lower left corner.
  explicit SolidPlan(const Eigen::Vector2d& size);

  /// Between two opposite corners [m].
  void cut(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) {
    set(corner, opposite, true);
  }
  void fill(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) {
    set(corner, opposite, false);
  }

  /// The lines between what is free and what is solid.
  [[nodiscard]] std::vector<WallSegment> walls() const;

 private:
  void set(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite, bool is_free);
  void add_walls(bool along_x, std::vector<WallSegment>& walls) const;
  [[nodiscard]] bool is_free(int column, int row) const;

  int columns_;
  int rows_;
  std::vector<bool> free_;
};

}  // namespace matchbox_slam
