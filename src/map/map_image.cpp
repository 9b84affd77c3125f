#include "matchbox_slam/map/map_image.hpp"

#include <stdexcept>
#include <string>

#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {
namespace {

std::uint8_t pixel_of(const OccupancyGrid& grid, const Cell& cell,
                      const MapThresholds& thresholds) {
  if (!grid.is_known(cell)) {
    return MapImage::kUnknownPixel;
  }
  const double occupancy = grid.occupancy(cell);
  if (occupancy >= thresholds.occupied) {
    return MapImage::kOccupiedPixel;
  }
  return occupancy <= thresholds.free ? MapImage::kFreePixel : MapImage::kUnknownPixel;
}

}  // namespace

CellState MapImage::state(const Cell& cell) const {
  const double bright = pixel(cell) / 255.0;
  const double occupancy = negate ? bright : 1.0 - bright;
  if (occupancy > occupied_threshold) {
    return CellState::kOccupied;
  }
  return occupancy < free_threshold ? CellState::kFree : CellState::kUnknown;
}

MapImage make_map_image(const OccupancyGrid& grid, const MapThresholds& thresholds) {
  if (!(thresholds.free >= 0.0 && thresholds.free < thresholds.occupied &&
        thresholds.occupied <= 1.0)) {
    throw std::invalid_argument("the thresholds of a map have to be 0 <= free (" +
                                to_string(thresholds.free) + ") < occupied (" +
                                to_string(thresholds.occupied) + ") <= 1");
  }
  CellBox bounds = grid.known_bounds();
  if (bounds.empty()) {
    bounds = {{0, 0}, {1, 1}};
  }
  MapImage map;
  map.width = bounds.width();
  map.height = bounds.height();
  map.resolution = grid.geometry().resolution();
  const Eigen::Vector2d corner = grid.geometry().corner(bounds.min);
  map.origin = {corner.x(), corner.y(), 0.0};
  map.pixels.reserve(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  for (int y = bounds.max.y - 1; y >= bounds.min.y; --y) {
    for (int x = bounds.min.x; x < bounds.max.x; ++x) {
      map.pixels.push_back(pixel_of(grid, {x, y}, thresholds));
    }
  }
  return map;
}

}  // namespace matchbox_slam
