#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "slam/local_map.hpp"
#include "slam/loop_closing.hpp"

namespace matchbox_slam {

using VariancesOf = std::function<std::vector<double>(const std::vector<std::size_t>& keys)>;

/// Of some key scans, distances first, the nearest of each visit of the robot, nearest first.
/// @param gap   by so many in number two are of different visits.
/// @param most  visits that count.
[[nodiscard]] std::vector<std::size_t> nearest_of_each_visit(
    std::vector<std::pair<double, std::size_t>> near, std::size_t gap, std::size_t most);

/// Key scans where the newest may have been taken too, though hardly known where from it: nearest
/// first, none near another.
/// @param are_apart     is asked of those alone that a search reaches.
/// @param variances_of  [m^2] of where some are from the newest; asked of those that are apart.
[[nodiscard]] std::vector<std::size_t> loop_candidates(const PlacedScans& keys,
                                                       const AreWeaklyConnected& are_apart,
                                                       const VariancesOf& variances_of,
                                                       const LoopOptions& options);

/// @param ways  from the newest.
[[nodiscard]] std::vector<std::size_t> loop_candidates(const PlacedScans& keys,
                                                       const PathUncertainty& ways,
                                                       const LoopOptions& options);

/// Searches the newest key scans, all at once, against those taken around one: a scan of one place
/// in a corridor fits anywhere along it.
/// @param sigma  [m] of where that one is from the newest.
[[nodiscard]] std::optional<FoundLoop> find_loop(const PlacedScans& keys, std::size_t candidate,
                                                 double sigma, const LoopOptions& options);

/// The newest key scan against an earlier one that is where it is known to be: only how they lie to
/// each other in detail is asked.
[[nodiscard]] std::optional<FoundLoop> find_near(const PlacedScans& keys, std::size_t candidate);

}  // namespace matchbox_slam
