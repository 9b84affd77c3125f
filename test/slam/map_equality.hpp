#pragma once

#include "matchbox_slam/map/scan_inserter.hpp"

namespace matchbox_slam {

/// Every cell of two maps, as stored.
[[nodiscard]] inline bool same_map(const SlamMap& a, const SlamMap& b) {
  const CellBox bounds = a.occupancy.known_bounds();
  const CellBox other = b.occupancy.known_bounds();
  if (bounds.min != other.min || bounds.max != other.max) {
    return false;
  }
  for (int y = bounds.min.y; y < bounds.max.y; ++y) {
    for (int x = bounds.min.x; x < bounds.max.x; ++x) {
      if (a.occupancy.stored({x, y}) != b.occupancy.stored({x, y}) ||
          a.field.distance({x, y}) != b.field.distance({x, y}) ||
          a.field.likelihood({x, y}) != b.field.likelihood({x, y})) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace matchbox_slam
