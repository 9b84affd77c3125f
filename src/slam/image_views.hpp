#pragma once

#include "map/image_walls.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/key_scans.hpp"

namespace matchbox_slam {

/// What a laser would have seen in an image of a map, so that a robot can be searched for in it as
/// among key scans: scans all round, from `viewpoints`. Nobody measured them, which each says of
/// itself; their stamps are negative, before those of any drive.
/// @param resolution  [m] a pixel.
/// @param map_from_image  pose of the image's lower left corner.
[[nodiscard]] KeyScans image_views(const ImageWalls& walls, double resolution,
                                   const Pose2& map_from_image);

/// Whether a key scan is one of those.
[[nodiscard]] inline bool is_image_view(const KeyScan& key) { return key.is_of_image(); }

}  // namespace matchbox_slam
