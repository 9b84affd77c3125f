#include "tools/map_shades.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/map_style.hpp"

namespace matchbox_slam {
namespace {

constexpr Shade kFreeShade = 1;

}  // namespace

Shade shade_of(const OccupancyGrid& map, const Cell& cell) {
  if (!map.is_known(cell)) {
    return kUnseenShade;
  }
  const double darkness = darkness_of(map.occupancy(cell));
  return static_cast<Shade>(kFreeShade + std::lround(darkness * (kDarkestShade - kFreeShade)));
}

Color color_of_shade(Shade shade) {
  return shade == kUnseenShade ? kUnknownColor
                               : color_of_darkness((shade - kFreeShade) /
                                                   static_cast<double>(kDarkestShade - kFreeShade));
}

MapShades::MapShades(const OccupancyGrid& map) : cells_(map.known_bounds()) {
  for (int y = cells_.min.y; y < cells_.max.y; ++y) {
    add_row(map, y);
  }
}

void MapShades::add_row(const OccupancyGrid& map, int y) {
  const std::size_t begin = runs_.size();
  for (int x = cells_.min.x; x < cells_.max.x; ++x) {
    const Shade shade = shade_of(map, {x, y});
    if (runs_.size() > begin && runs_.back().shade == shade &&
        runs_.back().length < std::numeric_limits<std::uint16_t>::max()) {
      ++runs_.back().length;
    } else {
      runs_.push_back({1, shade});
    }
  }
}

}  // namespace matchbox_slam
