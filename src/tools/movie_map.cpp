#include "tools/movie_map.hpp"

#include <algorithm>
#include <cmath>

#include "map/scan_drawing.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

bool has_moved(const PlacedScan& drawn, const PlacedScan& now, double cell) {
  constexpr double kViewDistance = 5.0;  // [m], so far away is what a turn moves
  const Eigen::Vector3d moved = difference(now.map_from_base, drawn.map_from_base);
  return moved.head<2>().norm() + kViewDistance * std::abs(moved.z()) > cell;
}

}  // namespace

bool MovieMap::is_outdated(const PlacedScans& keys) const {
  return keys.size() < drawn_.size() ||
         !std::equal(drawn_.begin(), drawn_.end(), keys.begin(),
                     [this](const PlacedScan& drawn, const PlacedScan& now) {
                       return drawn.scan == now.scan && !has_moved(drawn, now, options_.resolution);
                     });
}

bool MovieMap::is_too_large() const {
  constexpr int kTileSize = OccupancyGrid::Tiles::kTileSize;
  const auto longest = [](const CellBox& box) { return std::max(box.width(), box.height()); };
  return longest(grid_.tiles().tile_bounds()) * kTileSize > kMostCells &&
         longest(grid_.known_bounds()) > kMostCells;
}

void MovieMap::begin() {
  grid_ = OccupancyGrid(options_.resolution);
  drawn_.clear();
}

void MovieMap::add(const PlacedScan& key) {
  draw_occupancy(*key.scan->points(), key.map_from_base, options_, MapUse::kShown, memory_, grid_);
  drawn_.push_back(key);
}

void MovieMap::draw(const PlacedScans& keys, double finest_resolution) {
  options_.resolution = std::ldexp(finest_resolution, level_);
  if (is_outdated(keys)) {
    begin();
  }
  while (drawn_.size() < keys.size()) {
    add(keys[drawn_.size()]);
    if (is_too_large()) {
      options_.resolution = std::ldexp(finest_resolution, ++level_);
      begin();
    }
  }
}

}  // namespace matchbox_slam
