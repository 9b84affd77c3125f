#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "common/scratch_buffer.hpp"
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

/// Which parts of a box of cells somebody needs, in bands of rows: what lies between walls is often
/// most of it.
class NeededCells {
 public:
  static constexpr int kRows = 16;     ///< of a band
  static constexpr int kColumns = 32;  ///< at a time

  /// Columns from one up to another, counted from the box's first.
  struct Run {
    std::int32_t first = 0;
    std::int32_t last = 0;
  };

  /// Of a box of so many cells, none.
  void assign(std::int32_t columns, std::int32_t rows);

  /// And all in these, counted from the box's corner, as far as they are in the box.
  void include(const CellBox& cells);

  /// Calls visit(band, run) for each run of each band.
  template <typename Visitor>
  void visit(Visitor&& visit) const {
    for (std::int32_t band = 0; band < bands_; ++band) {
      const std::uint8_t* needed = &is_needed_[start_of(band)];
      for (std::int32_t i = 0; i < across_; ++i) {
        const std::int32_t first = i;
        while (i < across_ && needed[i] != 0) {
          ++i;
        }
        if (i > first) {
          visit(band, Run{first * kColumns, std::min(i * kColumns, columns_)});
        }
      }
    }
  }

 private:
  /// Of a band, in is_needed_.
  [[nodiscard]] std::size_t start_of(std::int32_t band) const {
    return static_cast<std::size_t>(band) * static_cast<std::size_t>(across_);
  }

  std::int32_t columns_ = 0;
  std::int32_t across_ = 0;
  std::int32_t bands_ = 0;
  std::vector<std::uint8_t> is_needed_;  ///< band by band
  CellBox newest_;                       ///< of these parts; neighbours mostly want the same
};

/// Part of the field's likelihoods, or their upper bounds over squares of cells, as one table of
/// the values that a search gives them, so that a look-up is one addition and rows can be read
/// whole. Made anew in the memory that it has.
class FieldWindow {
 public:
  using Values = std::array<std::uint8_t, 256>;

  static constexpr int kLevels = 4;
  /// On the second level turns and neighbours alone are taken together, and no translations.
  static constexpr std::array<BoundLevel, kLevels> kBounds{
      {{1, 0, 1}, {1, 2, 1}, {4, 3, 1}, {16, 8, 4}}};

  /// Cells that begin and end a window are multiples of this.
  static constexpr int kAlignment = 16;

  /// Begins another window: nothing of it is needed yet, and what is not is undefined.
  /// @param box  cells to hold, at least.
  void frame(const CellBox& box);

  /// All look-ups in the window and its bounds stay in such cells.
  void need(const CellBox& cells);

  /// Takes the values of a field's likelihoods; what the field does not know is 0.
  /// @param values  value of each likelihood.
  void read(const LikelihoodField& field, const Values& values);

  /// All of a box.
  void read(const LikelihoodField& field, const CellBox& box, const Values& values) {
    frame(box);
    need(box);
    read(field, values);
  }

  /// Makes upper bounds of these likelihoods, by level, up to one. The entry for a cell holds the
  /// maximum over the square from that cell (from the multiple of the grain below) that is as wide
  /// as the level's: whatever a point in that cell meets on any shift by up to the stride and the
  /// slack. Undefined where that is not all in the window.
  void make_bounds(int top, std::array<FieldWindow, kLevels>& bounds) const;

  [[nodiscard]] const TableLayout& layout() const { return layout_; }
  [[nodiscard]] const std::uint8_t* data() const { return table_.data(); }
  [[nodiscard]] std::ptrdiff_t pitch() const { return layout_.pitch; }

 private:
  void reshape(const Cell& corner, std::int32_t columns, std::int32_t rows, int grain_bits,
               int phase_bits);
  void raise(const FieldWindow& finer, const NeededCells& needed, std::initializer_list<int> by,
             int phase_bits);
  void write_row(std::int32_t row, const NeededCells::Run& run, const std::uint8_t* entries);
  [[nodiscard]] std::uint8_t* row(std::int32_t number) {
    return table_.data() + static_cast<std::ptrdiff_t>(layout_.pitch) * number;
  }
  [[nodiscard]] const std::uint8_t* row(std::int32_t number) const {
    return table_.data() + static_cast<std::ptrdiff_t>(layout_.pitch) * number;
  }

  TableLayout layout_;
  std::int32_t columns_ = 0;  ///< of entries, in all planes together
  std::int32_t rows_ = 0;
  NeededCells needed_;  ///< of the likelihoods
  ScratchBuffer<std::uint8_t> table_;
  std::vector<std::uint8_t> raised_;  ///< a row on the way
};

}  // namespace matchbox_slam
