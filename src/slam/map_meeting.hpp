#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/map_part.hpp"

namespace matchbox_slam {

/// Where one map lies in another one, by the place where both were seen to meet.
struct MapMeeting {
  std::size_t key = 0;  ///< key scan of the one that was found there, by its place on the way
  Pose2 there_from_map;
};

/// Whether to believe a meeting, which may take long to tell.
using IsBelieved = std::function<bool(const MapMeeting& meeting)>;

/// Searches one map in another one as a lost robot is searched for that drives its way again, by
/// each of its key scans (see `search_places`): with the same evidence a place is taken, or none.
/// What is not believed is searched on; the first one that is is the answer.
/// @param way       key scans of the one, in the order of the drive.
/// @param there     its field is rendered.
/// @param progress  is told how much of the way is done, 0...1; what it throws passes through.
[[nodiscard]] std::optional<MapMeeting> find_meeting(
    const PlacedScans& way, const MapPart& there, const EngineOptions& options,
    const IsBelieved& is_believed, const std::function<void(double done)>& progress);

}  // namespace matchbox_slam
