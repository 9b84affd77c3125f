#include "matching/olson/field_window.hpp"

#include <algorithm>
#include <numeric>

namespace matchbox_slam {
namespace {

using Tiles = MaximumPyramid::Tiles;
static_assert(Tiles::kTileBits == LikelihoodField::Tiles::kTileBits);

bool changes_nothing(const FieldWindow::Values& values) {
  FieldWindow::Values same;
  std::iota(same.begin(), same.end(), std::uint8_t{0});
  return values == same;
}

}  // namespace

FieldWindow::FieldWindow(const CellBox& box)
    : corner_(box.min),
      pitch_(box.width() + kPadding),
      table_(static_cast<std::size_t>(pitch_) * static_cast<std::size_t>(box.height()) + kPadding,
             0) {}

/// Tile by tile, row by row; what has no tile stays 0.
template <typename PlaneOf>
void FieldWindow::copy(const CellBox& box, const Values& values, const PlaneOf& plane_of) {
  constexpr int kSize = Tiles::kTileSize;
  const bool is_copy = changes_nothing(values);
  const Cell first = Tiles::tile_of(box.min);
  const Cell last = Tiles::tile_of({box.max.x - 1, box.max.y - 1});
  for (int ty = first.y; ty <= last.y; ++ty) {
    for (int tx = first.x; tx <= last.x; ++tx) {
      const MaximumPyramid::Plane* plane = plane_of(Cell{tx, ty});
      if (plane == nullptr) {
        continue;
      }
      const int x_begin = std::max(box.min.x, tx * kSize);
      const int x_end = std::min(box.max.x, (tx + 1) * kSize);
      const int y_end = std::min(box.max.y, (ty + 1) * kSize);
      for (int y = std::max(box.min.y, ty * kSize); y < y_end; ++y) {
        const std::uint8_t* from = plane->data() + Tiles::index_in_tile({x_begin, y});
        std::uint8_t* to = table_.data() + static_cast<std::ptrdiff_t>(y - corner_.y) * pitch_ +
                           (x_begin - corner_.x);
        if (is_copy) {
          std::copy_n(from, x_end - x_begin, to);
        } else {
          std::transform(from, from + (x_end - x_begin), to,
                         [&values](std::uint8_t likelihood) { return values[likelihood]; });
        }
      }
    }
  }
}

FieldWindow FieldWindow::of_likelihood(const LikelihoodField& field, const CellBox& box,
                                       const Values& values) {
  FieldWindow window(box);
  window.copy(box, values, [&](const Cell& position) -> const MaximumPyramid::Plane* {
    const LikelihoodField::Tile* tile = field.tiles().find(position);
    return tile == nullptr ? nullptr : &tile->likelihood;
  });
  return window;
}

FieldWindow FieldWindow::of_bounds(const LikelihoodField& field, int level, const CellBox& box,
                                   const Values& values) {
  FieldWindow window(box);
  const Tiles& bounds = field.bounds().level(level);
  window.copy(box, values, [&](const Cell& position) { return bounds.find(position); });
  return window;
}

FieldWindow FieldWindow::packed() const {
  FieldWindow window = *this;
  window.entry_bytes_ = kPackedRows;
  window.table_.assign(kPackedRows * table_.size(), 0);
  for (std::size_t row = 0; row < kPackedRows; ++row) {
    const std::size_t above = std::min(table_.size(), row * static_cast<std::size_t>(pitch_));
    for (std::size_t i = above; i < table_.size(); ++i) {
      window.table_[kPackedRows * (i - above) + row] = table_[i];
    }
  }
  return window;
}

}  // namespace matchbox_slam
