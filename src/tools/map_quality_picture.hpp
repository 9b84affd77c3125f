#pragma once

#include <string>
#include <vector>

#include "evaluation/map_quality.hpp"
#include "io/picture.hpp"
#include "matchbox_slam/io/map_file.hpp"

namespace matchbox_slam {

struct MeasuredMap {
  std::string name;
  MapImage map;
  MapQuality quality;
};

/// The maps beside each other, at least one. Corners are marked by dots, enclosed areas by a colour
/// each; name and counts stand below. The pictures share one scale, so that maps of one resolution
/// are as large as each other.
[[nodiscard]] Picture draw_map_qualities(const std::vector<MeasuredMap>& maps);

}  // namespace matchbox_slam
