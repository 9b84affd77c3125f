#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// Which key scans of a place make room, oldest first: those that at least `enough` newer ones were
/// taken beside, near enough to see the same, where
/// - what it hit was looked at, whether it is still there or not, by a third of so many of these,
///   or at least by another key scan around that stays: what nobody else saw is never given up;
/// - another one beside it is older and stays, or what it hit is there no more: the oldest one of a
///   place stays as long as it is right, so that a map which is renewed does not wander.
/// Of a place that is driven through once, none.
/// @param keys    those that lie well to each other, oldest first.
/// @param newest  [number] of all key scans; it and those shortly before stay, and the first of
/// all.
/// @return ids, in their order.
[[nodiscard]] std::vector<std::uint64_t> superfluous_scans(const PlacedScans& keys,
                                                           std::uint64_t newest,
                                                           std::size_t enough);

/// Whether so many key scans were taken beside the newest one that some may be superfluous.
[[nodiscard]] bool is_crowded(const PlacedScans& keys, std::size_t enough);

}  // namespace matchbox_slam
