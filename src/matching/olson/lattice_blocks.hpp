#pragma once

#include <algorithm>
#include <cstddef>

#include "matching/olson/correlative_search.hpp"
#include "matching/olson/field_window.hpp"
#include "matching/olson/scan_level.hpp"
#include "matching/olson/search_penalty.hpp"

namespace matchbox_slam {

/// What of a lattice is searched as one: on each level, from single rotations and blocks of one
/// cell up to the coarsest level that pays, rotations in groups and translations in blocks. Groups
/// are counted from the first rotation on, blocks along an axis from the offset 0 on. Made anew in
/// the memory that it has.
class LatticeBlocks {
 public:
  /// @param points  of the scan, neighbours one after the other.
  /// @param resolution  edge of a cell [m].
  void assign(const PointArrays& points, const SearchLattice& lattice, double resolution);

  [[nodiscard]] const SearchLattice& lattice() const { return lattice_; }
  [[nodiscard]] double resolution() const { return resolution_; }

  /// The coarsest level in use, 1 or more.
  [[nodiscard]] int top() const { return top_; }

  [[nodiscard]] static const BoundLevel& bounds_of(int level) {
    return FieldWindow::kBounds.at(static_cast<std::size_t>(level));
  }

  [[nodiscard]] const ScanLevel& scan_of(int level) const { return levels_[level]; }

  /// Rotations of a group, within the lattice.
  [[nodiscard]] StepRange thetas_of(int level, int group) const {
    const int turns = scan_of(level).turns;
    const int first = group * turns - lattice_.half_theta;
    return {first, std::min(first + turns - 1, lattice_.half_theta)};
  }

  /// The group that a rotation is in.
  [[nodiscard]] int group_of(int level, int theta) const {
    return (theta + lattice_.half_theta) / scan_of(level).turns;
  }

  [[nodiscard]] int last_group(int level) const { return group_of(level, lattice_.half_theta); }

  /// Offsets in steps that a block of a level stands for, within the lattice; none if it is
  /// outside.
  [[nodiscard]] StepRange steps_of(int level, int block) const {
    const int width = width_of(level);
    return {std::max(block * width, -lattice_.half_xy),
            std::min(block * width + width - 1, lattice_.half_xy)};
  }

  /// Blocks of a level that cover the lattice along an axis.
  [[nodiscard]] StepRange blocks_of(int level) const;

 private:
  [[nodiscard]] int width_of(int level) const {  ///< of a block [steps]
    return lattice_.steps_per_cell * bounds_of(level).stride;
  }

  SearchLattice lattice_;
  double resolution_ = 0.0;
  int top_ = 1;
  ScanLevels levels_;
};

}  // namespace matchbox_slam
