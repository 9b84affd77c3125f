#pragma once

#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Free-space violation: share of a scan's beams that go through walls, above which a place is
/// looked at with suspicion. A guess; with half of it aces is 14 % worse.
constexpr double kMostViolation = 0.1;

/// A match, and how it agrees with what is free.
struct CheckedMatch {
  MatchResult match;
  /// Share of the beams that cross walls, and twice those that end on the other side of one, 0...1.
  double violation = 0.0;
};

/// By exact search in the window of the prior.
[[nodiscard]] CheckedMatch search_and_check(const MatchProblem& problem,
                                            const OccupancyGrid& occupancy);

/// Whether a match is known to be right by itself: a good fit in one place alone, with hardly a
/// beam through walls, by a search that was not ended early.
[[nodiscard]] bool is_convincing(const CheckedMatch& checked);

}  // namespace matchbox_slam
