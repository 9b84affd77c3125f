#pragma once

#include <vector>

#include "map/image_walls.hpp"

namespace matchbox_slam {

/// Places on an image's free ground of which one is near each place where a robot has room, and in
/// its sight: a robot anywhere sees most of what is seen from one of them. The fewer of them the
/// better, so that those that most places see are taken first.
/// @param resolution  [m] a pixel.
/// Cost: some 0.1 s for 1000 m2.
[[nodiscard]] std::vector<Cell> viewpoints(const ImageWalls& walls, double resolution);

}  // namespace matchbox_slam
