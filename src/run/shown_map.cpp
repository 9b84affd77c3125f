#include "run/shown_map.hpp"

#include <set>

#include "map/scan_drawing.hpp"

namespace matchbox_slam {

OccupancyGrid shown_occupancy(const SlamMap& map, const PlacedScans& keys,
                              const MapOptions& options) {
  std::set<int> lasers;
  for (const PlacedScan& key : keys) {
    if (!lasers.insert(key.scan->laser()).second || key.scan->is_of_image()) {
      return map.occupancy;
    }
  }
  OccupancyGrid twice = map.occupancy;
  InsertionMemory memory;
  for (const PlacedScan& key : keys) {
    draw_occupancy(*key.scan->points(), key.map_from_base, options, MapUse::kShown, memory, twice);
  }
  return twice;
}

}  // namespace matchbox_slam
