#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/map_component.hpp"
#include "matchbox_slam/slam/place_search.hpp"
#include "slam/place_index.hpp"
#include "slam/relocalizer.hpp"

namespace matchbox_slam {

/// Where one map lies in another one, by the place where both were seen to meet.
struct MapMeeting {
  std::size_t key = 0;  ///< key scan of the one that was found there, by its place on the way
  Pose2 there_from_map;
};

/// Whether to believe a meeting, which may take long to tell.
using IsBelieved = std::function<bool(const MapMeeting& meeting)>;

/// Searches for where one map meets another one, key scan by key scan of the one, as a lost robot
/// is searched for that drives its way again: with the same evidence a place is taken, or none.
class MeetingWalk {
 public:
  /// @param there  its field is rendered.
  MeetingWalk(const MapComponent& there, const EngineOptions& options);

  /// Goes on to the next key scan. Where the map is found in the other one by it, and not at a
  /// place that was not believed: there_from_map.
  [[nodiscard]] std::optional<Pose2> go_on_to(const PlacedScan& key);

  /// The one that was found last is not the right one.
  void disbelieve(const Pose2& there_from_map);

 private:
  EngineOptions options_;
  std::vector<MapComponent> components_;  ///< the other map, and what was walked
  PlaceIndex index_;                      ///< of the other map
  PlaceSearch search_;
  std::vector<Pose2> not_believed_;  ///< there_from_map
};

/// Searches one map in another one as a lost robot is searched for that drives its way again, by
/// each of its key scans (see `MeetingWalk`). What is not believed is searched on; the first one
/// that is is the answer.
/// @param way       key scans of the one, in the order of the drive.
/// @param there     its field is rendered.
/// @param progress  is told how much of the way is done, 0...1; what it throws passes through.
[[nodiscard]] std::optional<MapMeeting> find_meeting(
    const PlacedScans& way, const MapComponent& there, const EngineOptions& options,
    const IsBelieved& is_believed, const std::function<void(double done)>& progress);

}  // namespace matchbox_slam
