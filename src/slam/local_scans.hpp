#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "matchbox_slam/matching/key_scan.hpp"
#include "slam/local_map.hpp"

namespace matchbox_slam {

/// [m] from the robot that a local map is made of key scans. A guess, tried on five drives with
/// loops (benchmark/reports/current/CONSTANTS.md): with half loop is 8 % and aces 10 % worse,
/// seattle 16 % better; with double aces 13 % worse.
constexpr double kLocalReach = 15.0;

/// [m] from where a key scan was taken.
[[nodiscard]] double distance(const PlacedScan& key, const Eigen::Vector2d& here);

/// Numbers of the key scans that were taken less than `reach` [m] from here.
[[nodiscard]] std::vector<std::size_t> keys_within(const PlacedScans& keys,
                                                   const Eigen::Vector2d& here, double reach);

/// Whether each of some key scans, by their numbers, does not belong with the newest.
using AreWeaklyConnected = std::function<std::vector<bool>(const std::vector<std::size_t>& keys)>;

/// @param are_apart  is asked of those alone that are near, or will be soon.
[[nodiscard]] LocalScans local_scans(const PlacedScans& keys, const AreWeaklyConnected& are_apart);

/// The same without some of them.
/// @param ids  in their order.
[[nodiscard]] LocalScans without(LocalScans near, const std::vector<std::uint64_t>& ids);

}  // namespace matchbox_slam
