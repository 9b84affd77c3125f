#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_state.hpp"

namespace matchbox_slam {

/// The key scans of one map among those of the map that it was merged into.
struct MergedStretch {
  std::size_t input = 0;  ///< number of the map that they are of
  std::size_t part = 0;   ///< of that: 0 the map, n the n-th one apart
  std::size_t begin = 0;  ///< the first of the key scans
  std::size_t end = 0;    ///< behind the last one
  Pose2 first = {};       ///< where the first one was in its own map
};

/// What joined two maps.
struct MergedJoint {
  double stamp = 0.0;        ///< [s] of the key scan of the one that was found in the other
  double stamp_there = 0.0;  ///< [s] of the key scan there that it was joined to
  std::size_t matched = 0;   ///< further key scans that were matched with some of the other
  std::size_t tried = 0;     ///< places where a loop was searched for
  std::size_t closed = 0;    ///< loops that were found, and are believed
};

/// A map of one or several maps.
struct MergedMap {
  MapPart part;
  LoopState loops;
  std::vector<MergedStretch> stretches;
  std::vector<MergedJoint> joints;
};

/// Is told which two maps are compared, by the first input that is in each, and how far that is,
/// 0...1. What it throws passes through.
using MergeProgress = std::function<void(std::size_t input, std::size_t there, double done)>;

/// Makes one map of those that meet. Each is searched in the others as a lost robot is that drives
/// its way again (`find_meeting`). Where it is found both graphs become one, with all that they
/// say of loops; then loops are searched for between the key scans of both, and what lies near is
/// matched, as while mapping. What a lost robot mapped apart is a map like others. The order of the
/// maps changes their names and the frame alone, and by that how cells are drawn.
/// @param maps  made of key scans alone; see EngineState.
/// @return      maps that do not meet, the one that holds the first input first; each in the frame
///              of the first input that is in it. Those without key scans are left out.
[[nodiscard]] std::vector<MergedMap> merge_maps(const std::vector<EngineState>& maps,
                                                const EngineOptions& options,
                                                const MergeProgress& progress);

/// To be saved, and to be gone on with by another drive. The robot is where it was with the last
/// key scan of the first input.
[[nodiscard]] EngineState state_of(MergedMap map);

}  // namespace matchbox_slam
