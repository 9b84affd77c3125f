#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {

OccupancyGrid::Tile& OccupancyGrid::touch(const Cell& tile) {
  static const Tile kBlank{};
  return tiles_.touch(tile, kBlank);
}

CellBox OccupancyGrid::known_bounds() const {
  constexpr int kSize = Tiles::kTileSize;
  CellBox bounds;
  const auto include = [&](int tx, int ty) {
    const Cell first{tx * kSize, ty * kSize};
    const Cell last{first.x + kSize - 1, first.y + kSize - 1};
    const Tile* tile = tiles_.find({tx, ty});
    if (tile == nullptr || (bounds.contains(first) && bounds.contains(last))) {
      return;
    }
    for (std::size_t i = 0; i < tile->size(); ++i) {
      if ((*tile)[i] != kUnknown) {
        bounds.include(
            {first.x + static_cast<int>(i) % kSize, first.y + static_cast<int>(i) / kSize});
      }
    }
  };
  // From the edges: what they span need not be looked at.
  const CellBox tiles = tiles_.tile_bounds();
  for (const int ty : {tiles.min.y, tiles.max.y - 1}) {
    for (int tx = tiles.min.x; tx < tiles.max.x; ++tx) {
      include(tx, ty);
    }
  }
  for (const int tx : {tiles.min.x, tiles.max.x - 1}) {
    for (int ty = tiles.min.y; ty < tiles.max.y; ++ty) {
      include(tx, ty);
    }
  }
  for (int ty = tiles.min.y; ty < tiles.max.y; ++ty) {
    for (int tx = tiles.min.x; tx < tiles.max.x; ++tx) {
      include(tx, ty);
    }
  }
  return bounds;
}

}  // namespace matchbox_slam
