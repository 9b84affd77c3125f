#include "slam/local_scans.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace matchbox_slam {
namespace {

// On the way to what lies apart, so that the map is made in time: with half aces is 10 % worse,
// with double seattle 6 % better (benchmark/reports/current/CONSTANTS.md).
constexpr double kLookahead = 10.0;  // [m]

/// In their order; of those that are equally near, the newest.
PlacedScans nearest(const PlacedScans& keys, const Eigen::Vector2d& here) {
  // For the time that it takes to render them. Half or double changes errors by up to 4 %
  // (CONSTANTS.md).
  constexpr std::size_t kMaxLocalScans = 100;
  if (keys.size() <= kMaxLocalScans) {
    return keys;
  }
  std::vector<std::pair<double, std::size_t>> ranked;  // and how many key scans came since
  for (std::size_t i = 0; i < keys.size(); ++i) {
    ranked.emplace_back(distance(keys[i], here), keys.size() - 1 - i);
  }
  const auto end = ranked.begin() + kMaxLocalScans;
  std::nth_element(ranked.begin(), end, ranked.end());
  std::sort(ranked.begin(), end, [](const auto& a, const auto& b) { return a.second > b.second; });
  PlacedScans nearest;
  std::transform(ranked.begin(), end, std::back_inserter(nearest),
                 [&keys](const auto& key) { return keys[keys.size() - 1 - key.second]; });
  return nearest;
}

}  // namespace

double distance(const PlacedScan& key, const Eigen::Vector2d& here) {
  return (key.map_from_base.translation() - here).norm();
}

std::vector<std::size_t> keys_within(const PlacedScans& keys, const Eigen::Vector2d& here,
                                     double reach) {
  std::vector<std::size_t> within;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (distance(keys[i], here) < reach) {
      within.push_back(i);
    }
  }
  return within;
}

LocalScans local_scans(const PlacedScans& keys, const AreWeaklyConnected& are_apart) {
  const Eigen::Vector2d here = keys.back().map_from_base.translation();
  const std::vector<std::size_t> soon = keys_within(keys, here, kLocalReach + kLookahead);
  const std::vector<bool> is_apart = are_apart(soon);
  LocalScans near;
  near.center = here;
  near.newest = keys.size() - 1;
  for (std::size_t i = 0; i < soon.size(); ++i) {
    const PlacedScan& key = keys[soon[i]];
    if (is_apart[i]) {
      near.apart.push_back(key.scan->id());
    } else if (distance(key, here) < kLocalReach) {
      near.all_belonging.push_back(key);
    }
  }
  near.belonging = nearest(near.all_belonging, here);
  return near;
}

LocalScans without(LocalScans near, const std::vector<std::uint64_t>& ids) {
  const auto is_out = [&ids](const PlacedScan& key) {
    return std::binary_search(ids.begin(), ids.end(), key.scan->id());
  };
  PlacedScans& all = near.all_belonging;
  all.erase(std::remove_if(all.begin(), all.end(), is_out), all.end());
  near.belonging = nearest(all, near.center);
  return near;
}

}  // namespace matchbox_slam
