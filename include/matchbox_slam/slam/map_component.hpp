#pragma once

#include <cstddef>
#include <map>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/slam/key_scans.hpp"

namespace matchbox_slam {

/// Components besides the map that are kept; then the one of the fewest key scans is given up for
/// the next.
constexpr std::size_t kMostDisconnectedComponents = 16;

/// A map in a frame of its own, with the key scans that it was made from: one of those that the map
/// falls apart into, as in the atlas of ORB-SLAM3. While the robot is not lost there is one.
struct MapComponent {
  SlamMap map;
  KeyScans key_scans;
  std::map<int, Pose2> last_inserted;  ///< map_from_base, by laser
  double begin = 0.0;                  ///< [s] stamp of its first scan
  std::size_t parent = 0;              ///< component that the robot was in before; itself: none
  Pose2 parent_from_component = {};    ///< its frame, as odometry tells
};

/// A scan that is to be inserted, not yet.
struct WaitingScan {
  std::size_t component = 0;  ///< of the map
  PlacedScan scan;
};

}  // namespace matchbox_slam
