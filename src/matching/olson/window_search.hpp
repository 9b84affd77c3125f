#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matching/olson/correlative_search.hpp"

namespace matchbox_slam {

/// What the search found, in metres and shares of the highest score.
struct FoundInWindow {
  bool is_any = false;  ///< else nothing is above the floor
  OptimalityProof proof;
  std::optional<Pose2> rival;
  double rival_share = 0.0;
  std::size_t candidates = 0;
  double step_xy = 0.0;     ///< [m]
  double step_theta = 0.0;  ///< [rad]
  /// Of a window that was clipped: how likely the truth is between it and what was asked for.
  double share_beyond = 0.0;
};

/// What a search works in.
struct WindowSearchMemory {
  std::vector<SearchPoint> points;
  std::vector<double> squares;  ///< of ranges
  SearchMemory search;
};

/// Searches the window of a problem's prior, or the configured one, for the pose of the highest
/// score: the scan's points are merged, window and steps chosen by how far they reach. The search
/// itself is search_lattice's.
[[nodiscard]] FoundInWindow find_in_window(const MatchProblem& problem, const OlsonOptions& options,
                                           WindowSearchMemory& memory);

}  // namespace matchbox_slam
