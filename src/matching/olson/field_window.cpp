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

FieldWindow::FieldWindow(const Cell& corner, std::int32_t columns, std::int32_t rows,
                         int grain_bits, int phase_bits)
    : layout_{corner, (columns >> phase_bits) + kPadding, 0, grain_bits, phase_bits},
      columns_(columns),
      rows_(rows) {
  layout_.plane = layout_.pitch * ((rows >> phase_bits) + kPaddingRows);
  // Left as it is: most of it is written anyway, and the rest never counts.
  table_.reset(new std::uint8_t[static_cast<std::size_t>(layout_.plane) << (2 * phase_bits)]);
}

/// Tile by tile, row by row.
FieldWindow FieldWindow::of_likelihood(const LikelihoodField& field, const CellBox& box,
                                       const Values& values) {
  constexpr int kSize = Tiles::kTileSize;
  const CellBox all = aligned(box);
  FieldWindow window(all.min, all.width(), all.height(), 0, 0);
  const bool is_copy = changes_nothing(values);
  const Cell first = Tiles::tile_of(all.min);
  const Cell last = Tiles::tile_of({all.max.x - 1, all.max.y - 1});
  for (int ty = first.y; ty <= last.y; ++ty) {
    for (int tx = first.x; tx <= last.x; ++tx) {
      const LikelihoodField::Tile* tile = field.tiles().find({tx, ty});
      const int x_begin = std::max(all.min.x, tx * kSize);
      const int x_end = std::min(all.max.x, (tx + 1) * kSize);
      const int y_end = std::min(all.max.y, (ty + 1) * kSize);
      for (int y = std::max(all.min.y, ty * kSize); y < y_end; ++y) {
        std::uint8_t* to = window.row(y - all.min.y) + (x_begin - all.min.x);
        if (tile == nullptr) {
          std::fill_n(to, x_end - x_begin, std::uint8_t{0});
          continue;
        }
        const std::uint8_t* from = tile->likelihood.data() + Tiles::index_in_tile({x_begin, y});
        if (is_copy) {
          std::copy_n(from, x_end - x_begin, to);
        } else {
          std::transform(from, from + (x_end - x_begin), to,
                         [&values](std::uint8_t likelihood) { return values[likelihood]; });
        }
      }
    }
  }
  return window;
}

std::vector<FieldWindow> FieldWindow::bounds(int top) const {
  // Squares of 2 x 2 cells, 4 x 4, 8 x 8, and from each fourth one of those 28 x 28.
  std::vector<FieldWindow> bounds;
  bounds.push_back(raised({1}, 0));
  bounds.push_back(bounds[0].raised({2}, 0));
  if (top > 1) {
    bounds.push_back(bounds[1].raised({4}, kPhaseBits));
  }
  if (top > 2) {
    bounds.push_back(bounds[2].raised({2, 4, 5}, kPhaseBits));
  }
  return bounds;
}

void FieldWindow::write_row(std::int32_t row, const std::vector<std::uint8_t>& entries) {
  const std::int32_t phases = 1 << layout_.phase_bits;
  std::uint8_t* to = table_.get() +
                     static_cast<std::ptrdiff_t>(layout_.plane) * phases * (row & (phases - 1)) +
                     static_cast<std::ptrdiff_t>(layout_.pitch) * (row >> layout_.phase_bits);
  const auto count = static_cast<std::size_t>(columns_ >> layout_.phase_bits);
  for (std::int32_t phase = 0; phase < phases; ++phase, to += layout_.plane) {
    pick_phase(entries.data() + phase, count, to);
  }
}

/// Each entry raised to those that are so many columns and rows beyond: of a window in planes, its
/// first plane alone, whose entries stand for more cells.
FieldWindow FieldWindow::raised(const std::vector<int>& by, int phase_bits) const {
  const int coarser = layout_.phase_bits;
  FieldWindow window(layout_.corner, columns_ >> coarser, rows_ >> coarser, coarser, phase_bits);
  const auto count = static_cast<std::size_t>(window.columns_);
  const auto farthest = static_cast<std::size_t>(by.back());
  std::vector<std::uint8_t> column(count + farthest);
  std::vector<std::uint8_t> entries(count);
  for (std::int32_t y = 0; y + by.back() < window.rows_; ++y) {
    maxima(row(y), row(y + by.front()), column.size(), column.data());
    for (std::size_t i = 1; i < by.size(); ++i) {
      raise_to(row(y + by[i]), column.size(), column.data());
    }
    std::uint8_t* to = phase_bits == 0 ? window.row(y) : entries.data();
    maxima(column.data(), column.data() + by.front(), count, to);
    for (std::size_t i = 1; i < by.size(); ++i) {
      raise_to(column.data() + by[i], count, to);
    }
    if (phase_bits != 0) {
      window.write_row(y, entries);
    }
  }
  return window;
}

}  // namespace matchbox_slam
