#include "slam/shown_map.hpp"

#include <set>

namespace matchbox_slam {

OccupancyGrid shown_occupancy(const SlamMap& map, const PlacedScans& keys,
                              const MapOptions& options) {
  std::set<int> lasers;
  for (const PlacedScan& key : keys) {
    if (!lasers.insert(key.scan->laser()).second) {
      return map.occupancy;
    }
  }
  SlamMap twice = map;
  for (const PlacedScan& key : keys) {
    insert_unrendered(*key.scan->points(), key.map_from_base, options, twice);
  }
  return twice.occupancy;
}

}  // namespace matchbox_slam
