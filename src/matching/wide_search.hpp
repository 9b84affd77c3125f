#pragma once

#include <vector>

#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// By exact search in the window of the prior (Olson 2009), whatever the matcher of the run. It
/// ends after so many look-ups as take some 10 ms.
[[nodiscard]] MatchResult search_exactly(const MatchProblem& problem);

/// Where else the scan fits than where the prior has it: the best poses of a window that is wide in
/// position and in heading, and of one that is wide in position alone, since corridors that cross
/// are alike after a quarter of a turn. Up to two, which differ.
[[nodiscard]] std::vector<MatchResult> search_widely(const MatchProblem& problem);

}  // namespace matchbox_slam
