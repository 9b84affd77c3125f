#include "matchbox_slam/map/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {

double OccupancyGrid::blend(const Cell& cell, double observed, double quality) {
  static const Tile kBlank{};
  Stored& stored = tiles_.touch(Tiles::tile_of(cell), kBlank)[Tiles::index_in_tile(cell)];
  const double before = to_probability(stored);
  const double after = before + quality * (observed - before);
  stored = static_cast<Stored>(1 + std::lround(after * 65534.0));
  return after;
}

void OccupancyGrid::restore(const Cell& cell, Stored value) {
  static const Tile kBlank{};
  tiles_.touch(Tiles::tile_of(cell), kBlank)[Tiles::index_in_tile(cell)] = value;
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
