#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "slam/local_map.hpp"
#include "slam/loop_closing.hpp"

namespace matchbox_slam {

/// Of some key scans, distances first, the nearest of each visit of the robot, nearest first.
/// @param gap   by so many in number two are of different visits.
/// @param most  visits that count.
[[nodiscard]] std::vector<std::size_t> nearest_of_each_visit(
    std::vector<std::pair<double, std::size_t>> near, std::size_t gap, std::size_t most);

/// A key scan where the newest one may have been taken, too.
struct LoopCandidate {
  std::size_t key;
  double sigma;  ///< [m], how well it is known where it is from the newest
};

/// Those of which that is hardly known: nearest first, none near another.
/// @param ways  from the newest.
[[nodiscard]] std::vector<LoopCandidate> loop_candidates(const PlacedScans& keys,
                                                         const PathUncertainty& ways,
                                                         const LoopOptions& options);

/// Searches the newest key scans, all at once, against those taken around one: a scan of one place
/// in a corridor fits anywhere along it.
[[nodiscard]] std::optional<FoundLoop> find_loop(const PlacedScans& keys,
                                                 const LoopCandidate& candidate,
                                                 const LoopOptions& options);

/// The newest key scan against an earlier one that is where it is known to be: only how they lie to
/// each other in detail is asked.
[[nodiscard]] std::optional<FoundLoop> find_near(const PlacedScans& keys, std::size_t candidate);

}  // namespace matchbox_slam
