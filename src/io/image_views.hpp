#pragma once

#include <cstddef>

#include "map/image_walls.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/key_scans.hpp"

namespace matchbox_slam {

/// What a laser would have seen in an image of a map, so that a robot can be searched for in it as
/// among key scans: scans all round, from `viewpoints`. Nobody measured them, which each says of
/// itself; their stamps are `image_stamp`, before those of any drive.
/// @param resolution  [m] a pixel.
/// @param map_from_image  pose of the image's lower left corner.
[[nodiscard]] KeyScans image_views(const ImageWalls& walls, double resolution,
                                   const Pose2& map_from_image);

/// [s], of the view of that place, of so many. A saved map has this alone of it.
[[nodiscard]] inline double image_stamp(std::size_t place, std::size_t places) {
  return static_cast<double>(place) - static_cast<double>(places);
}

/// Whether a stamp [s] is one of those: no clock of a robot is before the beginning of time.
[[nodiscard]] inline bool is_image_stamp(double stamp) { return stamp < 0.0; }

}  // namespace matchbox_slam
