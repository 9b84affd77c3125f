#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
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

/// What the bounds of a level of the search are for.
struct BoundLevel {
  int stride;  ///< width of a block of translations [cells]
  int slack;   ///< along each axis, how far a point may be moved besides [cells]
  int grain;   ///< along each axis, cells to an entry
  /// Width of the square that an entry is the maximum of [cells].
  [[nodiscard]] constexpr int width() const { return stride + slack + grain; }
};

/// Part of the field's likelihoods, or their upper bounds over squares of cells, as one table of
/// the values that a search gives them, so that a look-up is one addition and rows can be read
/// whole.
class FieldWindow {
 public:
  using Values = std::array<std::uint8_t, 256>;

  static constexpr int kLevels = 4;
  /// On the second level turns and neighbours alone are taken together, and no translations.
  static constexpr std::array<BoundLevel, kLevels> kBounds{
      {{1, 0, 1}, {1, 2, 1}, {4, 3, 1}, {16, 8, 4}}};

  /// Cells that begin and end a window are multiples of this.
  static constexpr int kAlignment = 16;

  /// @param box     cells to copy, at least; what the field does not know is 0.
  /// @param values  value of each likelihood.
  static FieldWindow of_likelihood(const LikelihoodField& field, const CellBox& box,
                                   const Values& values);

  /// Upper bounds of these likelihoods, by level, up to one. The entry for a cell holds the maximum
  /// over the square from that cell (from the multiple of the grain below) that is as wide as the
  /// level's: whatever a point in that cell meets on any shift by up to the stride and the slack.
  /// Undefined where that is not all in the window.
  [[nodiscard]] std::vector<FieldWindow> bounds(int top) const;

  [[nodiscard]] const TableLayout& layout() const { return layout_; }
  [[nodiscard]] const std::uint8_t* data() const { return table_.get(); }
  [[nodiscard]] std::ptrdiff_t pitch() const { return layout_.pitch; }

 private:
  FieldWindow(const Cell& corner, std::int32_t columns, std::int32_t rows, int grain_bits,
              int phase_bits);

  [[nodiscard]] FieldWindow raised(const std::vector<int>& by, int phase_bits) const;
  void write_row(std::int32_t row, const std::vector<std::uint8_t>& entries);
  [[nodiscard]] std::uint8_t* row(std::int32_t number) const {
    return table_.get() + static_cast<std::ptrdiff_t>(layout_.pitch) * number;
  }

  TableLayout layout_;
  std::int32_t columns_;  ///< of entries, in all planes together
  std::int32_t rows_;
  std::unique_ptr<std::uint8_t[]> table_;
};

}  // namespace matchbox_slam
