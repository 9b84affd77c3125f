#pragma once

#include <cstddef>

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// Calls `take(point)` with some points of a scan, spread evenly.
/// @param most  so many at most.
template <typename Take>
void take_some(const PointScan& scan, std::size_t most, Take&& take) {
  const std::size_t stride = (scan.points.size() + most - 1) / most;
  for (std::size_t i = stride / 2; i < scan.points.size(); i += stride) {
    take(scan.points[i]);
  }
}

}  // namespace matchbox_slam
