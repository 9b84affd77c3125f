#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/slam/loop_closing.hpp"

namespace matchbox_slam {

/// Key scans where the newest may have been taken too, though hardly known where from it: nearest
/// first, none near another.
/// @param variances  [m^2] of where each is from the newest.
[[nodiscard]] std::vector<std::size_t> loop_candidates(const PlacedScans& keys,
                                                       const std::vector<bool>& is_apart,
                                                       const std::vector<double>& variances,
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
