#include "matchbox_slam/slam/near_map.hpp"

#include <algorithm>
#include <iterator>

#include "matching/rendered_map.hpp"

namespace matchbox_slam {
namespace {

// Guesses, tried on five drives with loops (benchmark/reports/current/CONSTANTS.md). kReach:
// with half loop is 8 % and aces 10 % worse, seattle 16 % better; with double aces 13 % worse.
// kSoon, on the way to what lies apart, so that the map is made in time: with half aces is 10 %
// worse, with double seattle 6 % better.
constexpr double kReach = 15.0;  // [m]
constexpr double kSoon = 10.0;   // [m]

double distance(const PlacedScan& key, const Eigen::Vector2d& here) {
  return (key.map_from_base.translation() - here).norm();
}

/// In their order; of those that are equally near, the newest.
PlacedScans nearest(const PlacedScans& keys, const Eigen::Vector2d& here) {
  // For the time that it takes to render them. Half or double changes errors by up to 4 %
  // (CONSTANTS.md).
  constexpr std::size_t kMost = 100;
  if (keys.size() <= kMost) {
    return keys;
  }
  std::vector<std::pair<double, std::size_t>> ranked;  // and how many key scans came since
  for (std::size_t i = 0; i < keys.size(); ++i) {
    ranked.emplace_back(distance(keys[i], here), keys.size() - 1 - i);
  }
  const auto end = ranked.begin() + kMost;
  std::nth_element(ranked.begin(), end, ranked.end());
  std::sort(ranked.begin(), end, [](const auto& a, const auto& b) { return a.second > b.second; });
  PlacedScans nearest;
  std::transform(ranked.begin(), end, std::back_inserter(nearest),
                 [&keys](const auto& key) { return keys[keys.size() - 1 - key.second]; });
  return nearest;
}

}  // namespace

std::vector<std::uint64_t> ids_of(const PlacedScans& keys) {
  std::vector<std::uint64_t> ids;
  std::transform(keys.begin(), keys.end(), std::back_inserter(ids),
                 [](const PlacedScan& key) { return key.scan->id(); });
  return ids;
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

NearScans near_scans(const PlacedScans& keys, const AreApart& are_apart) {
  const Eigen::Vector2d here = keys.back().map_from_base.translation();
  const std::vector<std::size_t> soon = keys_within(keys, here, kReach + kSoon);
  const std::vector<bool> is_apart = are_apart(soon);
  NearScans near;
  near.center = here;
  near.newest = keys.size() - 1;
  near.is_any_apart = std::find(is_apart.begin(), is_apart.end(), true) != is_apart.end();
  for (std::size_t i = 0; i < soon.size(); ++i) {
    const PlacedScan& key = keys[soon[i]];
    if (!is_apart[i] && distance(key, here) < kReach) {
      near.belonging.push_back(key);
    }
  }
  near.belonging = nearest(near.belonging, here);
  return near;
}

bool NearMap::is_due(const PlacedScans& keys) const {
  // A guess, a third of what it reaches. With half loop is 7 % worse, with double 20 %, and aces 7
  // % (CONSTANTS.md).
  constexpr double kMoved = 5.0;  // [m]
  return !map_ || distance(keys.back(), center_) >= kMoved;
}

NearMap::NearMap(const NearScans& near, const MapOptions& map_options,
                 const LikelihoodFieldOptions& field_options)
    : NearMap(rendered(near.belonging, map_options, field_options), near.center, near.newest + 1,
              ids_of(near.belonging)) {}

NearMap NearMap::as_of(std::size_t taken, const PlacedScans& keys, const MapOptions& map_options,
                       const LikelihoodFieldOptions& field_options) const {
  PlacedScans then;
  for (const std::uint64_t id : drawn_) {
    if (id < taken) {
      then.push_back(keys[id]);
    }
  }
  return {rendered(then, map_options, field_options), center_, taken, ids_of(then)};
}

void NearMap::take_new(const PlacedScans& keys, const MapOptions& map_options) {
  if (taken_ == keys.size()) {
    return;
  }
  for (; taken_ < keys.size(); ++taken_) {
    const PlacedScan& key = keys[taken_];
    if (map_ && distance(key, center_) < kReach) {
      insert_unrendered(*key.scan->points(), key.map_from_base, map_options, *map_);
      drawn_.push_back(key.scan->id());
    }
  }
  if (map_) {
    map_->field.render();
  }
}

}  // namespace matchbox_slam
