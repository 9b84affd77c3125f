#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace matchbox_slam {

/// A cell of an unbounded grid. Cell (i, j) covers [i, i+1) x [j, j+1) cell sizes of the map frame,
/// so cell (0, 0) has its lower left corner at the map's origin and indices may be negative.
struct Cell {
  int x = 0;
  int y = 0;
};

[[nodiscard]] inline bool operator==(const Cell& a, const Cell& b) {
  return a.x == b.x && a.y == b.y;
}
[[nodiscard]] inline bool operator!=(const Cell& a, const Cell& b) { return !(a == b); }

/// Cells from `min` up to but without `max`.
struct CellBox {
  Cell min;
  Cell max;

  [[nodiscard]] int width() const { return max.x - min.x; }
  [[nodiscard]] int height() const { return max.y - min.y; }
  [[nodiscard]] bool empty() const { return max.x <= min.x || max.y <= min.y; }
  [[nodiscard]] bool contains(const Cell& cell) const {
    return cell.x >= min.x && cell.x < max.x && cell.y >= min.y && cell.y < max.y;
  }

  /// Grows the box so that the cell lies in it.
  void include(const Cell& cell) {
    const CellBox before = empty() ? CellBox{cell, cell} : *this;
    min = {std::min(before.min.x, cell.x), std::min(before.min.y, cell.y)};
    max = {std::max(before.max.x, cell.x + 1), std::max(before.max.y, cell.y + 1)};
  }
};

/// The cells that lie in both boxes.
[[nodiscard]] inline CellBox intersection(const CellBox& a, const CellBox& b) {
  return {{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y)},
          {std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y)}};
}

/// A coordinate [cells] rounded down, within 2^28 cells of the origin; NaN is the lower end.
/// Without branches, so that loops over it are vectorised, and without std::floor, which takes
/// several times as long where it is no single instruction.
[[nodiscard]] inline int cell_index(double cells) {
  constexpr double kFarthest = 1 << 28;
  const double above = cells > -kFarthest ? cells : -kFarthest;
  const double within = above < kFarthest ? above : kFarthest;
  const auto towards_zero = static_cast<int>(within);
  return towards_zero - (within < towards_zero ? 1 : 0);
}

/// The only place where metres of the map frame become cells and back.
class GridGeometry {
 public:
  /// @param resolution  edge of a cell [m], > 0.
  explicit GridGeometry(double resolution) : resolution_(resolution), inverse_(1.0 / resolution) {}

  [[nodiscard]] double resolution() const { return resolution_; }

  /// The cell that a point [m] lies in. Coordinates beyond 2^28 cells from the origin are taken as
  /// that far, NaN as the lower end.
  [[nodiscard]] Cell cell_at(const Eigen::Vector2d& point) const {
    return {index_at(point.x()), index_at(point.y())};
  }

  [[nodiscard]] Eigen::Vector2d center(const Cell& cell) const {
    return {(cell.x + 0.5) * resolution_, (cell.y + 0.5) * resolution_};
  }

  /// Lower left corner of a cell.
  [[nodiscard]] Eigen::Vector2d corner(const Cell& cell) const {
    return {cell.x * resolution_, cell.y * resolution_};
  }

 private:
  [[nodiscard]] int index_at(double coordinate) const { return cell_index(coordinate * inverse_); }

  double resolution_;
  double inverse_;
};

}  // namespace matchbox_slam
