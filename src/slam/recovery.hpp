#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/map_component.hpp"
#include "matchbox_slam/slam/place_search.hpp"
#include "slam/place_index.hpp"

namespace matchbox_slam {

/// Looks for a lost robot with a key scan of the map that it makes meanwhile, the newest that was
/// not searched yet. Places that look alike, by the index, are searched exactly (Olson 2009), and
/// become hypotheses, which compete by evidence added up over key scans (a sequential test; Wald
/// 1945): each says for a place by how much it is better explained there than anywhere else in the
/// map, whatever went before. So rooms that are alike say nothing for any of them, whether they are
/// mapped or not. The answer is the place that is sure.
/// @param stamp   [s] of the newest scan.
/// @param active  the component that the robot makes meanwhile.
[[nodiscard]] std::optional<PlaceHypothesis> search_places(
    double stamp, const Pose2& active_from_base, const std::vector<MapComponent>& components,
    std::size_t active, const PlaceIndex& index, const EngineOptions& options, PlaceSearch& search);

}  // namespace matchbox_slam
