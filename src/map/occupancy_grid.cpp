#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {

OccupancyGrid::Tile& OccupancyGrid::touch(const Cell& tile) {
  static const Tile kBlank{};
  return tiles_.touch(tile, kBlank);
}

CellBox OccupancyGrid::known_bounds() const {
  constexpr int kSize = Tiles::kTileSize;
  CellBox bounds;
  const CellBox tiles = tiles_.tile_bounds();
  for (int ty = tiles.min.y; ty < tiles.max.y; ++ty) {
    for (int tx = tiles.min.x; tx < tiles.max.x; ++tx) {
      const Tile* tile = tiles_.find({tx, ty});
      if (tile == nullptr) {
        continue;
      }
      for (std::size_t i = 0; i < tile->size(); ++i) {
        if ((*tile)[i] == kUnknown) {
          continue;
        }
        bounds.include(
            {tx * kSize + static_cast<int>(i) % kSize, ty * kSize + static_cast<int>(i) / kSize});
      }
    }
  }
  return bounds;
}

}  // namespace matchbox_slam
