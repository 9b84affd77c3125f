#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "matchbox_slam/slam/engine_state.hpp"
#include "merging/map_joining.hpp"

namespace matchbox_slam {

/// Is told how many maps are left, and how much of searching them in each other is done, 0...1.
/// What it throws passes through.
using MergeProgress = std::function<void(std::size_t maps, double done)>;

/// The map that a state holds, and its disconnected components, without those that have no key
/// scans. What waits to be inserted is, and a loop that is searched for is closed.
/// @param input  number of the state among those that are merged.
[[nodiscard]] std::vector<MergedMap> maps_of(const EngineState& state, const EngineOptions& options,
                                             std::size_t input = 0);

/// Makes one map of those that meet. Each is searched in the others as a lost robot is that drives
/// its way again (`find_meeting`). Where it is found both graphs become one, with all that they
/// say of loops; then loops are searched for between the key scans of both, and what lies near is
/// matched, as while mapping. A disconnected component is a map like others. The order of the
/// maps changes their names and the frame alone, and by that how cells are drawn.
/// @param maps  made of key scans alone; see EngineState.
/// @return      maps that do not meet, the one that holds the first input first; each in the frame
///              of the first input that is in it. Those without key scans are left out.
[[nodiscard]] std::vector<MergedMap> merged_maps(const std::vector<EngineState>& maps,
                                                 const EngineOptions& options,
                                                 const MergeProgress& progress);

/// To be saved, and to be gone on with by another drive. The robot is where it was with the last
/// key scan of the first input.
[[nodiscard]] EngineState state_of(MergedMap map);

}  // namespace matchbox_slam
