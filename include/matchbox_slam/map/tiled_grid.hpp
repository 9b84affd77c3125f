#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "matchbox_slam/map/grid_geometry.hpp"

namespace matchbox_slam {

/// An unbounded grid that holds memory only for square tiles that were written to, 2^TileBits cells
/// wide. `Tile` is whatever one tile holds; a missing tile reads as null.
///
/// Copies are cheap and independent: they share tiles until one of them writes to a tile. So a copy
/// is a snapshot that another thread may read while the original goes on being written to.
template <typename Tile, int TileBits>
class TiledGrid {
 public:
  static constexpr int kTileBits = TileBits;
  static constexpr int kTileSize = 1 << TileBits;
  static constexpr int kTileMask = kTileSize - 1;

  /// Position of a cell's tile, in tiles; arithmetic shift rounds towards minus infinity.
  [[nodiscard]] static Cell tile_of(const Cell& cell) {
    return {cell.x >> TileBits, cell.y >> TileBits};
  }

  /// Row-major index of a cell within its tile.
  [[nodiscard]] static std::size_t index_in_tile(const Cell& cell) {
    return (static_cast<std::size_t>(cell.y & kTileMask) << TileBits) |
           static_cast<std::size_t>(cell.x & kTileMask);
  }

  [[nodiscard]] const Tile* find(const Cell& tile) const {
    const auto dx = static_cast<unsigned>(tile.x - bounds_.min.x);
    const auto dy = static_cast<unsigned>(tile.y - bounds_.min.y);
    if (dx >= width_ || dy >= height_) {
      return nullptr;
    }
    return tiles_[static_cast<std::size_t>(dy) * width_ + dx].get();
  }

  /// The tile for writing, made from `blank` when there is none yet.
  Tile& touch(const Cell& tile, const Tile& blank) {
    if (!bounds_.contains(tile)) {
      make_room({tile, {tile.x + 1, tile.y + 1}});
    }
    std::shared_ptr<Tile>& slot = tiles_[slot_of(tile)];
    if (slot == nullptr) {
      slot = std::make_shared<Tile>(blank);
    } else if (slot.use_count() > 1) {
      slot = std::make_shared<Tile>(*slot);  // a snapshot still reads the old one
    } else {
      // A snapshot that another thread just gave up had read this tile before we write to it.
#ifdef __SANITIZE_THREAD__
      std::shared_ptr<Tile>(slot).reset();  // orders the same; the sanitizer knows no fences
#else
      std::atomic_thread_fence(std::memory_order_acquire);
#endif
    }
    return *slot;
  }

  /// Grows once, and not tile by tile, for a box around tiles that are about to be written to.
  /// @param tiles  not empty.
  void make_room(const CellBox& tiles) {
    TiledGrid bigger;
    bigger.bounds_ = bounds_;
    bigger.bounds_.include(tiles.min);
    bigger.bounds_.include({tiles.max.x - 1, tiles.max.y - 1});
    if (bigger.bounds_.width() == bounds_.width() && bigger.bounds_.height() == bounds_.height()) {
      return;
    }
    bigger.width_ = static_cast<unsigned>(bigger.bounds_.width());
    bigger.height_ = static_cast<unsigned>(bigger.bounds_.height());
    bigger.tiles_.resize(static_cast<std::size_t>(bigger.width_) * bigger.height_);
    for (int y = bounds_.min.y; y < bounds_.max.y; ++y) {
      for (int x = bounds_.min.x; x < bounds_.max.x; ++x) {
        bigger.tiles_[bigger.slot_of({x, y})] = std::move(tiles_[slot_of({x, y})]);
      }
    }
    *this = std::move(bigger);
  }

  /// Smallest box of tiles, in tiles, around all tiles that exist.
  [[nodiscard]] CellBox tile_bounds() const { return bounds_; }

  [[nodiscard]] std::size_t tile_count() const {
    return static_cast<std::size_t>(std::count_if(
        tiles_.begin(), tiles_.end(), [](const auto& tile) { return tile != nullptr; }));
  }

  [[nodiscard]] std::size_t bytes() const {
    return tile_count() * sizeof(Tile) + tiles_.capacity() * sizeof(tiles_[0]);
  }

 private:
  [[nodiscard]] std::size_t slot_of(const Cell& tile) const {
    return static_cast<std::size_t>(tile.y - bounds_.min.y) * width_ +
           static_cast<std::size_t>(tile.x - bounds_.min.x);
  }

  CellBox bounds_;
  unsigned width_ = 0;
  unsigned height_ = 0;
  std::vector<std::shared_ptr<Tile>> tiles_;
};

}  // namespace matchbox_slam
