#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/map/likelihood_field.hpp"

namespace matchbox_slam {

/// Where a table has the entries of cells. An entry stands for a square of 2^grain_bits cells.
/// Entries 2^phase_bits apart, as the blocks of a search are, lie next to each other: those of each
/// phase make a plane of their own.
struct TableLayout {
  Cell corner;             ///< the first cell; a multiple of FieldWindow::kAlignment
  std::int32_t pitch = 0;  ///< from row to row, within a plane
  std::int32_t plane = 0;  ///< from plane to plane
  std::int32_t grain_bits = 0;
  std::int32_t phase_bits = 0;
};

/// Part of the field's likelihoods, or their upper bounds over squares of cells, as one table of
/// the values that a search gives them, so that a look-up is one addition and rows can be read
/// whole.
class FieldWindow {
 public:
  using Values = std::array<std::uint8_t, 256>;

  /// Levels of bounds; one of level l is for blocks of translations stride(l) cells wide.
  static constexpr int kLevels = 3;
  [[nodiscard]] static constexpr int stride(int level) { return 1 << (2 * level); }

  /// Cells that begin and end a window are multiples of this.
  static constexpr int kAlignment = 16;

  /// @param box     cells to copy, at least; what the field does not know is 0.
  /// @param values  value of each likelihood.
  static FieldWindow of_likelihood(const LikelihoodField& field, const CellBox& box,
                                   const Values& values);

  /// Upper bounds of these likelihoods, by level, up to one. The entry for a cell of level l holds
  /// the maximum over the square from that cell (on level 2, from the multiple of 4 below) that is
  /// stride(l) + 1 cells wide (on level 2, four more): whatever a point in that cell meets on any
  /// shift by up to stride(l) cells in x and in y. 0 where that is not all in the window.
  [[nodiscard]] std::vector<FieldWindow> bounds(int top) const;

  [[nodiscard]] const TableLayout& layout() const { return layout_; }
  [[nodiscard]] const std::uint8_t* data() const { return table_.data(); }
  [[nodiscard]] std::ptrdiff_t pitch() const { return layout_.pitch; }

 private:
  FieldWindow(const Cell& corner, std::int32_t columns, std::int32_t rows, int grain_bits,
              int phase_bits);

  [[nodiscard]] FieldWindow finest_bounds() const;
  [[nodiscard]] FieldWindow second_bounds() const;
  [[nodiscard]] FieldWindow third_bounds() const;
  void write_row(std::int32_t row, const std::vector<std::uint8_t>& entries);
  [[nodiscard]] const std::uint8_t* row(std::int32_t number, std::int32_t phase_x = 0,
                                        std::int32_t phase_y = 0) const;

  TableLayout layout_;
  std::int32_t columns_;  ///< of entries, in all planes together
  std::int32_t rows_;
  std::vector<std::uint8_t> table_;
};

}  // namespace matchbox_slam
