#include "matchbox_slam/slam/near_map.hpp"

#include <algorithm>
#include <cstddef>

namespace matchbox_slam {

namespace {

/// The key scans nearest to a place, in their order: many of one place say the same.
PlacedScans nearest(const PlacedScans& keys, const Eigen::Vector2d& here) {
  constexpr std::size_t kMost = 100;
  if (keys.size() <= kMost) {
    return keys;
  }
  std::vector<double> distances;
  for (const PlacedScan& key : keys) {
    distances.push_back((key.map_from_base.translation() - here).norm());
  }
  std::vector<double> sorted = distances;
  std::nth_element(sorted.begin(), sorted.begin() + kMost, sorted.end());
  PlacedScans nearest;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (distances[i] < sorted[kMost]) {
      nearest.push_back(keys[i]);
    }
  }
  return nearest;
}

}  // namespace

SlamMap rendered(const PlacedScans& keys, const MapOptions& map_options,
                 const LikelihoodFieldOptions& field_options) {
  SlamMap map(map_options, field_options);
  for (const PlacedScan& key : keys) {
    insert_unrendered(*key.scan->points(), key.map_from_base, map_options, map);
  }
  map.field.render_all();
  return map;
}

void NearMap::add(const PlacedScans& keys, const std::vector<bool>& is_apart, bool is_outdated,
                  const MapOptions& map_options, const LikelihoodFieldOptions& field_options) {
  constexpr double kReach = 15.0;  // [m]
  constexpr double kMoved = 5.0;   // [m] after which others have come near, or have drifted apart
  const PlacedScan& newest = keys.back();
  const Eigen::Vector2d here = newest.map_from_base.translation();
  if (map_) {
    insert_scan(*newest.scan->points(), newest.map_from_base, map_options, *map_);
  }
  bool is_any_apart = false;
  PlacedScans belonging;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const bool is_near = (keys[i].map_from_base.translation() - here).norm() < kReach;
    if (is_near && !is_apart[i]) {
      belonging.push_back(keys[i]);
    }
    is_any_apart = is_any_apart || (is_near && is_apart[i]);
  }
  if (!is_any_apart && !is_outdated) {
    map_.reset();
    return;
  }
  if (map_ && (here - center_).norm() < kMoved) {
    return;
  }
  map_ = rendered(nearest(belonging, here), map_options, field_options);
  center_ = here;
}

}  // namespace matchbox_slam
