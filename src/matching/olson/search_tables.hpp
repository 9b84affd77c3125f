#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/scratch_buffer.hpp"
#include "matching/olson/field_window.hpp"
#include "matching/olson/lattice_blocks.hpp"
#include "matching/olson/rotated_points.hpp"
#include "matching/olson/window_sums.hpp"

namespace matchbox_slam {

/// What a search reads: the field's values in reach of the points and their bounds by level, and
/// where in these tables the points lie at a rotation. The latter is kept for some groups of each
/// level, since a search comes back to them. Made anew in the memory that it has.
class SearchTables {
 public:
  /// @param points, blocks  of the scan and the lattice; outlive this.
  void assign(const PointArrays& points, const LatticeBlocks& blocks, const LikelihoodField& field,
              const FieldWindow::Values& value_of_likelihood);

  /// Whether nothing is in reach of any pose.
  [[nodiscard]] bool empty() const { return useful_.empty(); }

  /// The windows of a level's points in the bounds at the middle of a group of rotations, moved by
  /// blocks. Good until this is asked for another group.
  [[nodiscard]] PointWindows bounds(int level, int group, int x, int y);

  /// Points in the likelihoods at one rotation, and their steps within the cell, row by row.
  struct Cells {
    PointWindows windows;
    const std::int32_t* classes;
  };

  /// At one rotation, moved by cells. Good until this is asked for another rotation.
  [[nodiscard]] Cells cells(int theta, int x, int y);

 private:
  /// Where the points of a level lie in its table, by groups of rotations.
  struct LocatedPoints {
    std::vector<int> groups;               ///< of each slot
    ScratchBuffer<std::int32_t> offsets;   // most slots are never used
    ScratchBuffer<std::uint16_t> weights;  ///< of the points that can meet anything, else 0
    ScratchBuffer<std::int32_t> classes;   ///< of the finest level: steps in the cell, row by row

    void clear(std::size_t slots, std::size_t points);
  };

  class Reach;

  void need_around(const PointArrays& points, const Reach& reach, int farthest);
  [[nodiscard]] bool is_in_range() const;
  void rotate(const PointArrays& points, double theta, double shift);
  [[nodiscard]] std::size_t locate(int level, int group);

  const LatticeBlocks* blocks_ = nullptr;
  CellBox useful_;  ///< cells from which every look-up stays in the tables
  FieldWindow likelihoods_;
  std::array<FieldWindow, FieldWindow::kLevels> bounds_;  ///< by level
  RotatedPoints rotated_;
  std::array<LocatedPoints, FieldWindow::kLevels> located_;  ///< by level
};

}  // namespace matchbox_slam
