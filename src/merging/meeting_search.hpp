#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "merging/map_joining.hpp"

namespace matchbox_slam {

/// Two maps by number, of which one is searched in the other one along its way, or back.
struct MeetingPass {
  std::size_t map = 0;
  std::size_t there = 0;
  bool is_back = false;
};

/// Of the first pass that finds them: which one, and both as one map.
struct FoundMeeting {
  std::size_t pass = 0;
  MergedMap both;  ///< not drawn
};

/// Makes the passes side by side, on as many cores as there are. The answer is that of the first
/// one by number that finds something, however long which one took; later ones are given up.
/// @param progress  is told in this thread how much of all passes is done, 0...1. What it throws
///                  ends them, and passes through.
[[nodiscard]] std::optional<FoundMeeting> search_meetings(
    const std::vector<MergedMap>& maps, const std::vector<MeetingPass>& passes,
    const EngineOptions& options, const std::function<void(double done)>& progress);

}  // namespace matchbox_slam
