#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "matching/olson/correlative_search.hpp"
#include "matching/olson/field_window.hpp"
#include "matching/olson/rotated_points.hpp"

namespace matchbox_slam {

/// The scan as a level of the search sees it: rotations in groups, and neighbouring points as one.
/// At each rotation of a group, each point is within half the level's slack (BoundLevel), along x
/// and along y, of where the one that stands for it is at the middle of the group. Hence a bound
/// for the one, over a square that is as much wider, holds for all of them at all rotations.
struct ScanLevel {
  int turns = 1;               ///< rotations in a group; a multiple of the next finer level's
  PointArrays points;          ///< weights up to 255
  std::int64_t unbounded = 0;  ///< what the points that move farther score at most

  void clear() {
    turns = 1;
    points.clear();
    unbounded = 0;
  }
};

/// The levels of a scan, made anew in the memory that they have.
class ScanLevels {
 public:
  /// From the finest level, which has the points themselves and single rotations, up to one.
  /// @param points  neighbours one after the other, else few are seen as one.
  /// @param resolution  edge of a cell [m].
  void assign(const PointArrays& points, const SearchLattice& lattice, double resolution, int top);

  [[nodiscard]] const ScanLevel& operator[](int level) const {
    return levels_[static_cast<std::size_t>(level)];
  }

 private:
  std::array<ScanLevel, FieldWindow::kLevels> levels_;
  std::vector<double> squares_;  ///< of the points' ranges, on the way
};

}  // namespace matchbox_slam
