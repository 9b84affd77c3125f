#include "slam/map_meeting.hpp"

#include <limits>
#include <memory>
#include <vector>

#include "slam/recovery.hpp"

namespace matchbox_slam {
namespace {

/// Key scans are farther apart than the scans that a robot is searched with, and nothing waits for
/// them.
RecoveryOptions unhurried(RecoveryOptions options) {
  constexpr int kTimesAsMany = 5;  // as Relocalizer has it where scans are rare
  options.interval = 0.0;
  options.key_scans *= kTimesAsMany;
  return options;
}

}  // namespace

std::optional<MapMeeting> find_meeting(const KeyScans& map, const MapPart& there,
                                       const EngineOptions& options,
                                       const std::function<void(double done)>& progress) {
  constexpr std::size_t kWalked = 1;  // the part that the robot makes; it has left none
  std::vector<MapPart> parts{there, {SlamMap(options.map, options.field), {}, {}, 0.0, kWalked}};
  MapPart& walked = parts[kWalked];
  const std::vector<SearchedPlace> places = searched_places(parts, kWalked);
  const RecoveryOptions recovery = unhurried(options.recovery);
  PlaceSearch search;
  for (std::size_t i = 0; i < map.size(); ++i) {
    progress(static_cast<double>(i) / static_cast<double>(map.size()));
    const PlacedScan& key = map.all()[i];
    const std::shared_ptr<const PointScan> points = key.scan->points();
    walked.key_scans.add(key);
    insert_scan(*points, key.map_from_base, options.map, walked.map);
    search.stamp = std::numeric_limits<double>::lowest();  // stamps may go back between drives
    const std::optional<PlaceHypothesis> found =
        search_places(*points, key.map_from_base, parts, kWalked, places, recovery, search);
    if (found) {
      return MapMeeting{i, found->part_from_apart};
    }
  }
  return std::nullopt;
}

}  // namespace matchbox_slam
