#include "matching/olson/field_window.hpp"

#include <algorithm>
#include <numeric>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

using Tiles = LikelihoodField::Tiles;

// Vectors of a window may be read this far beyond what counts in them.
constexpr std::int32_t kPadding = 32;
constexpr std::int32_t kPaddingRows = 4;

constexpr int kPhaseBits = 2;
constexpr std::int32_t kPhases = 1 << kPhaseBits;

bool changes_nothing(const FieldWindow::Values& values) {
  FieldWindow::Values same;
  std::iota(same.begin(), same.end(), std::uint8_t{0});
  return values == same;
}

/// Down for the first cell, up for the last.
CellBox aligned(const CellBox& box) {
  constexpr int kLast = FieldWindow::kAlignment - 1;
  return {{box.min.x & ~kLast, box.min.y & ~kLast},
          {(box.max.x + kLast) & ~kLast, (box.max.y + kLast) & ~kLast}};
}

MATCHBOX_SIMD_CLONES void raise_to(const std::uint8_t* __restrict__ others, std::size_t count,
                                   std::uint8_t* __restrict__ entries) {
  for (std::size_t i = 0; i < count; ++i) {
    entries[i] = std::max(entries[i], others[i]);
  }
}

MATCHBOX_SIMD_CLONES void maxima(const std::uint8_t* __restrict__ some,
                                 const std::uint8_t* __restrict__ others, std::size_t count,
                                 std::uint8_t* __restrict__ entries) {
  for (std::size_t i = 0; i < count; ++i) {
    entries[i] = std::max(some[i], others[i]);
  }
}

/// Each fourth entry, from the first on.
MATCHBOX_SIMD_CLONES void pick_phase(const std::uint8_t* __restrict__ entries, std::size_t count,
                                     std::uint8_t* __restrict__ picked) {
  for (std::size_t i = 0; i < count; ++i) {
    picked[i] = entries[kPhases * i];
  }
}

}  // namespace

void FieldWindow::reshape(const Cell& corner, std::int32_t columns, std::int32_t rows,
                          int grain_bits, int phase_bits) {
  layout_ = {corner, (columns >> phase_bits) + kPadding, 0, grain_bits, phase_bits};
  layout_.plane = layout_.pitch * ((rows >> phase_bits) + kPaddingRows);
  columns_ = columns;
  rows_ = rows;
  // Most of it is written, and the rest never counts.
  table_.make(static_cast<std::size_t>(layout_.plane) << (2 * phase_bits));
}

void FieldWindow::frame(const CellBox& box) {
  const CellBox all = aligned(box);
  reshape(all.min, all.width(), all.height(), 0, 0);
  needed_.assign(columns_, rows_);
}

void FieldWindow::need(const CellBox& cells) {
  const Cell& corner = layout_.corner;
  needed_.include({{cells.min.x - corner.x, cells.min.y - corner.y},
                   {cells.max.x - corner.x, cells.max.y - corner.y}});
}

void FieldWindow::read(const LikelihoodField& field, const Values& values) {
  constexpr int kSize = Tiles::kTileSize;
  static_assert(kAlignment == NeededCells::kRows && kSize % kAlignment == 0,
                "a band is in one row of tiles");
  const bool is_copy = changes_nothing(values);
  const Cell& corner = layout_.corner;
  needed_.visit([&](std::int32_t band, const NeededCells::Run& run) {
    const int y = corner.y + band * NeededCells::kRows;
    for (int x = corner.x + run.first; x < corner.x + run.last;) {
      const Cell cell{x, y};
      const int end = std::min((Tiles::tile_of(cell).x + 1) * kSize, corner.x + run.last);
      const auto count = static_cast<std::size_t>(end - x);
      const LikelihoodField::Tile* tile = field.tiles().find(Tiles::tile_of(cell));
      const std::uint8_t* from =
          tile == nullptr ? nullptr : tile->likelihood.data() + Tiles::index_in_tile(cell);
      std::uint8_t* to = row(band * NeededCells::kRows) + (x - corner.x);
      for (std::ptrdiff_t i = 0; i < NeededCells::kRows; ++i, to += layout_.pitch) {
        if (tile == nullptr) {
          std::fill_n(to, count, std::uint8_t{0});
        } else if (is_copy) {
          std::copy_n(from + i * kSize, count, to);
        } else {
          std::transform(from + i * kSize, from + i * kSize + count, to,
                         [&values](std::uint8_t likelihood) { return values[likelihood]; });
        }
      }
      x = end;
    }
  });
}

void FieldWindow::make_bounds(int top, std::array<FieldWindow, kLevels>& bounds) const {
  // Squares of 2 x 2 cells, 4 x 4, 8 x 8, and from each fourth one of those 28 x 28.
  bounds[0].raise(*this, needed_, {1}, 0);
  bounds[1].raise(bounds[0], needed_, {2}, 0);
  if (top > 1) {
    bounds[2].raise(bounds[1], needed_, {4}, kPhaseBits);
  }
  if (top > 2) {
    bounds[3].raise(bounds[2], needed_, {2, 4, 5}, kPhaseBits);
  }
}

/// Part of a row.
/// @param entries  of the run.
void FieldWindow::write_row(std::int32_t row, const NeededCells::Run& run,
                            const std::uint8_t* entries) {
  const std::int32_t phases = 1 << layout_.phase_bits;
  std::uint8_t* to = table_.data() +
                     static_cast<std::ptrdiff_t>(layout_.plane) * phases * (row & (phases - 1)) +
                     static_cast<std::ptrdiff_t>(layout_.pitch) * (row >> layout_.phase_bits) +
                     (run.first >> layout_.phase_bits);
  const auto count = static_cast<std::size_t>((run.last - run.first) >> layout_.phase_bits);
  for (std::int32_t phase = 0; phase < phases; ++phase, to += layout_.plane) {
    pick_phase(entries + phase, count, to);
  }
}

/// Becomes a finer one's entries, each raised to those that are so many columns and rows beyond: of
/// one in planes, of its first plane alone, whose entries stand for more cells.
/// @param needed  of the likelihoods' cells.
void FieldWindow::raise(const FieldWindow& finer, const NeededCells& needed,
                        std::initializer_list<int> by, int phase_bits) {
  const int coarser = finer.layout_.phase_bits;
  const int grain_bits = finer.layout_.grain_bits + coarser;
  reshape(finer.layout_.corner, finer.columns_ >> coarser, finer.rows_ >> coarser, grain_bits,
          phase_bits);
  const int first = *by.begin();
  const int farthest = *(by.end() - 1);
  // A run and what is beyond it, then the run's entries.
  raised_.resize(2 * static_cast<std::size_t>(columns_ + farthest));
  needed.visit([&](std::int32_t band, const NeededCells::Run& cells) {
    const NeededCells::Run run{cells.first >> grain_bits, cells.last >> grain_bits};
    const auto count = static_cast<std::size_t>(run.last - run.first);
    const std::size_t wide = count + static_cast<std::size_t>(farthest);
    std::uint8_t* column = raised_.data();
    std::uint8_t* entries = column + wide;
    const std::int32_t from = (band * NeededCells::kRows) >> grain_bits;
    const std::int32_t to_row =
        std::min(((band + 1) * NeededCells::kRows) >> grain_bits, rows_ - farthest);
    for (std::int32_t y = from; y < to_row; ++y) {
      const auto finer_row = [&](std::int32_t beyond) { return finer.row(y + beyond) + run.first; };
      maxima(finer_row(0), finer_row(first), wide, column);
      for (auto more = by.begin() + 1; more != by.end(); ++more) {
        raise_to(finer_row(*more), wide, column);
      }
      std::uint8_t* to = phase_bits == 0 ? row(y) + run.first : entries;
      maxima(column, column + first, count, to);
      for (auto more = by.begin() + 1; more != by.end(); ++more) {
        raise_to(column + *more, count, to);
      }
      if (phase_bits != 0) {
        write_row(y, run, entries);
      }
    }
  });
}

void NeededCells::assign(std::int32_t columns, std::int32_t rows) {
  columns_ = columns;
  across_ = (columns + kColumns - 1) / kColumns;
  bands_ = (rows + kRows - 1) / kRows;
  newest_ = {};
  is_needed_.assign(static_cast<std::size_t>(across_) * static_cast<std::size_t>(bands_), 0);
}

void NeededCells::include(const CellBox& cells) {
  const std::int32_t first = std::max(0, cells.min.x) / kColumns;
  const std::int32_t last = std::min(across_, (cells.max.x + kColumns - 1) / kColumns);
  const std::int32_t first_band = std::max(0, cells.min.y) / kRows;
  const std::int32_t last_band = std::min(bands_, (cells.max.y + kRows - 1) / kRows);
  const CellBox parts{{first, first_band}, {last, last_band}};
  if (parts.min == newest_.min && parts.max == newest_.max) {
    return;
  }
  newest_ = parts;
  for (std::int32_t band = first_band; band < last_band; ++band) {
    for (std::int32_t i = first; i < last; ++i) {
      is_needed_[start_of(band) + static_cast<std::size_t>(i)] = 1;
    }
  }
}

}  // namespace matchbox_slam
