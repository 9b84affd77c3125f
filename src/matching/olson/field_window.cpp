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
  table_.assign(static_cast<std::size_t>(layout_.plane) << (2 * phase_bits), 0);
}

/// Tile by tile, row by row; what has no tile stays 0.
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
      if (tile == nullptr) {
        continue;
      }
      const int x_begin = std::max(all.min.x, tx * kSize);
      const int x_end = std::min(all.max.x, (tx + 1) * kSize);
      const int y_end = std::min(all.max.y, (ty + 1) * kSize);
      for (int y = std::max(all.min.y, ty * kSize); y < y_end; ++y) {
        const std::uint8_t* from = tile->likelihood.data() + Tiles::index_in_tile({x_begin, y});
        std::uint8_t* to = window.table_.data() +
                           static_cast<std::ptrdiff_t>(y - all.min.y) * window.layout_.pitch +
                           (x_begin - all.min.x);
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
  std::vector<FieldWindow> bounds{finest_bounds()};
  if (top > 0) {
    bounds.push_back(bounds[0].second_bounds());
  }
  if (top > 1) {
    bounds.push_back(bounds[1].third_bounds());
  }
  return bounds;
}

const std::uint8_t* FieldWindow::row(std::int32_t number, std::int32_t phase_x,
                                     std::int32_t phase_y) const {
  return table_.data() +
         static_cast<std::ptrdiff_t>(layout_.plane) * (kPhases * phase_y + phase_x) +
         static_cast<std::ptrdiff_t>(layout_.pitch) * number;
}

void FieldWindow::write_row(std::int32_t row, const std::vector<std::uint8_t>& entries) {
  const std::int32_t phases = 1 << layout_.phase_bits;
  std::uint8_t* to = table_.data() +
                     static_cast<std::ptrdiff_t>(layout_.plane) * phases * (row & (phases - 1)) +
                     static_cast<std::ptrdiff_t>(layout_.pitch) * (row >> layout_.phase_bits);
  const auto count = static_cast<std::size_t>(columns_ >> layout_.phase_bits);
  if (phases == 1) {
    std::copy_n(entries.begin(), count, to);
    return;
  }
  for (std::int32_t phase = 0; phase < phases; ++phase, to += layout_.plane) {
    pick_phase(entries.data() + phase, count, to);
  }
}

/// Of the likelihoods: 2 x 2 cells.
FieldWindow FieldWindow::finest_bounds() const {
  FieldWindow bounds(layout_.corner, columns_, rows_, 0, 0);
  const auto count = static_cast<std::size_t>(columns_);
  std::vector<std::uint8_t> entries(count);
  for (std::int32_t y = 0; y + 1 < rows_; ++y) {
    std::copy_n(row(y), count, entries.begin());
    for (const std::uint8_t* other : {row(y) + 1, row(y + 1), row(y + 1) + 1}) {
      raise_to(other, count, entries.data());
    }
    bounds.write_row(y, entries);
  }
  return bounds;
}

/// Of the finest bounds: 5 x 5 cells, by overlapping squares of 2 x 2.
FieldWindow FieldWindow::second_bounds() const {
  FieldWindow bounds(layout_.corner, columns_, rows_, 0, kPhaseBits);
  const auto count = static_cast<std::size_t>(columns_);
  std::vector<std::uint8_t> entries(count);
  for (std::int32_t y = 0; y + 3 < rows_; ++y) {
    std::fill(entries.begin(), entries.end(), std::uint8_t{0});
    for (const std::int32_t dy : {0, 2, 3}) {
      for (const std::int32_t dx : {0, 2, 3}) {
        raise_to(row(y + dy) + dx, count, entries.data());
      }
    }
    bounds.write_row(y, entries);
  }
  return bounds;
}

/// Of the second ones: 20 x 20 cells, by four times four squares of 5 x 5. A square that begins
/// 5 k cells on is of phase k.
FieldWindow FieldWindow::third_bounds() const {
  FieldWindow bounds(layout_.corner, columns_ / kPhases, rows_ / kPhases, kPhaseBits, kPhaseBits);
  const auto count = static_cast<std::size_t>(bounds.columns_);
  std::vector<std::uint8_t> entries(count);
  for (std::int32_t y = 0; y + kPhases <= bounds.rows_; ++y) {
    std::fill(entries.begin(), entries.end(), std::uint8_t{0});
    for (std::int32_t dy = 0; dy < kPhases; ++dy) {
      for (std::int32_t dx = 0; dx < kPhases; ++dx) {
        raise_to(row(y + dy, dx, dy) + dx, count, entries.data());
      }
    }
    bounds.write_row(y, entries);
  }
  return bounds;
}

}  // namespace matchbox_slam
