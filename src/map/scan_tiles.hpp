#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "matchbox_slam/map/grid_geometry.hpp"

namespace matchbox_slam {

/// What one scan says about the cells that it saw, before the map hears of it, in tiles that are
/// used again by the next scan: whoever takes what they say leaves them blank.
template <typename Value>
class ScanTiles {
 public:
  static constexpr int kTileBits = 6;
  static constexpr int kTileSize = 1 << kTileBits;
  static constexpr int kTileMask = kTileSize - 1;
  /// Rows lie two tiles apart, so that a step out of the tile shows in the position's bits.
  static constexpr int kPitch = 2 * kTileSize;
  using Tile = std::array<Value, static_cast<std::size_t>(kPitch* kTileSize)>;

  [[nodiscard]] static Cell tile_of(const Cell& cell) {
    return {cell.x >> kTileBits, cell.y >> kTileBits};
  }

  [[nodiscard]] static int position_in_tile(const Cell& cell) {
    return (cell.y & kTileMask) * kPitch + (cell.x & kTileMask);
  }

  [[nodiscard]] static bool is_inside(int position) {
    return (position & ~(kTileMask * (kPitch + 1))) == 0;
  }

  /// Begins with nothing seen.
  /// @param cells  most of what is seen lies in these.
  void assign(const CellBox& cells) {
    const Cell last = tile_of({cells.max.x - 1, cells.max.y - 1});
    bounds_ = {tile_of(cells.min), {last.x + 1, last.y + 1}};
    slots_.assign(area_of(bounds_), nullptr);
    used_ = 0;
    current_ = nullptr;
  }

  /// A tile for writing.
  Tile& touch(const Cell& tile) {
    if (current_ == nullptr || tile != current_position_) {
      current_ = &find_or_make(tile);
      current_position_ = tile;
    }
    return *current_;
  }

  /// Calls take(tile, marks) for each tile that was touched, by rows.
  template <typename Take>
  void take_tiles(Take&& take) {
    auto slot = slots_.begin();
    for (int y = bounds_.min.y; y < bounds_.max.y; ++y) {
      for (int x = bounds_.min.x; x < bounds_.max.x; ++x, ++slot) {
        if (*slot != nullptr) {
          take(Cell{x, y}, **slot);
        }
      }
    }
    constexpr std::size_t kKeptTiles = 4'000'000 / sizeof(Tile);
    tiles_.resize(std::min(tiles_.size(), kKeptTiles));
  }

 private:
  [[nodiscard]] static std::size_t area_of(const CellBox& box) {
    return static_cast<std::size_t>(box.width()) * static_cast<std::size_t>(box.height());
  }

  [[nodiscard]] std::size_t slot_of(const Cell& tile) const {
    return static_cast<std::size_t>(tile.y - bounds_.min.y) *
               static_cast<std::size_t>(bounds_.width()) +
           static_cast<std::size_t>(tile.x - bounds_.min.x);
  }

  void grow(const Cell& tile) {
    const CellBox before = bounds_;
    const std::vector<Tile*> slots = slots_;
    bounds_.include(tile);
    slots_.assign(area_of(bounds_), nullptr);
    auto slot = slots.begin();
    for (int y = before.min.y; y < before.max.y; ++y) {
      for (int x = before.min.x; x < before.max.x; ++x) {
        slots_[slot_of({x, y})] = *slot++;
      }
    }
  }

  Tile& find_or_make(const Cell& tile) {
    if (!bounds_.contains(tile)) {
      grow(tile);
    }
    Tile*& slot = slots_[slot_of(tile)];
    if (slot == nullptr) {
      if (used_ == tiles_.size()) {
        tiles_.push_back(std::make_unique<Tile>());
      }
      slot = tiles_[used_++].get();
    }
    return *slot;
  }

  CellBox bounds_;                            ///< in tiles
  std::vector<Tile*> slots_;                  ///< row by row; null where nothing was seen
  std::vector<std::unique_ptr<Tile>> tiles_;  ///< from `used_` on blank
  std::size_t used_ = 0;
  Tile* current_ = nullptr;  // consecutive cells of a ray mostly share their tile
  Cell current_position_;
};

}  // namespace matchbox_slam
