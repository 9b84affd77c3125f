#pragma once

#include <map>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/slam/key_scans.hpp"

namespace matchbox_slam {

/// A map in a frame of its own, with the key scans that it was made from. While the robot is not
/// lost there is one.
struct MapPart {
  SlamMap map;
  KeyScans key_scans;
  std::map<int, Pose2> last_inserted;  ///< map_from_base, by laser
  double begin = 0.0;                  ///< [s] stamp of its first scan
};

}  // namespace matchbox_slam
