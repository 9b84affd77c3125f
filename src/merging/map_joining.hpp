#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "matchbox_slam/slam/map_component.hpp"
#include "merging/map_meeting.hpp"

namespace matchbox_slam {

/// The key scans of one map among those of the map that it was merged into.
struct MergedStretch {
  std::size_t input = 0;      ///< number of the map that they are of
  std::size_t component = 0;  ///< of that: 0 the map, n the n-th component besides
  std::size_t begin = 0;      ///< the first of the key scans
  std::size_t end = 0;        ///< behind the last one
  Pose2 first = {};           ///< where the first one was in its own map
};

/// What joined two maps.
struct MergedJoint {
  double stamp = 0.0;        ///< [s] of the key scan of the one that was found in the other
  double stamp_there = 0.0;  ///< [s] of the key scan there that it was joined to
  std::size_t matched = 0;   ///< further key scans that were matched with some of the other
  std::size_t tried = 0;     ///< places where a loop was searched for
  std::size_t closed = 0;    ///< loops that were found, and are inliers
};

/// A map of one or several maps.
struct MergedMap {
  MapComponent component;
  LoopState loops;
  std::vector<MergedStretch> stretches;
  std::vector<MergedJoint> joints;
};

/// Draws a map by its key scans.
void draw(const EngineOptions& options, MapComponent& component);

/// Two maps that meet as one: both graphs become one, with all that they say of loops; from where
/// they meet on what lies near is matched, and loops are searched for, as while mapping. None where
/// what they saw contradicts that (`do_agree`).
/// @param meeting  of the map in the other one.
/// @param go_on    is called now and then; what it throws passes through.
/// @return         with the key scans of `there` first; not drawn.
[[nodiscard]] std::optional<MergedMap> joined(const MergedMap& map, const MergedMap& there,
                                              const MapMeeting& meeting,
                                              const EngineOptions& options,
                                              const std::function<void()>& go_on);

}  // namespace matchbox_slam
