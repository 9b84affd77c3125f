#include "slam/local_map.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "matching/rendered_map.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLookahead = 10.0;  // [m] to what lies apart, so that the map is made in time

constexpr std::size_t kMaxLocalScans = 100;  // for the time that it takes to render them
// Key scans, what a robot adds that stays in one room: a guess.
constexpr std::size_t kMaxDrawnScans = 5 * kMaxLocalScans / 2;

/// In their order; of those that are equally near, the newest.
PlacedScans nearest(const PlacedScans& keys, const Eigen::Vector2d& here) {
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

/// In their order.
std::vector<std::uint64_t> ids_of(const PlacedScans& keys) {
  std::vector<std::uint64_t> ids;
  std::transform(keys.begin(), keys.end(), std::back_inserter(ids),
                 [](const PlacedScan& key) { return key.scan->id(); });
  return ids;
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

bool begins_with(const PlacedScans& keys, const PlacedScans& first) {
  const auto is_same = [](const PlacedScan& then, const PlacedScan& key) {
    return then.scan == key.scan && then.map_from_base == key.map_from_base;
  };
  return first.size() <= keys.size() &&
         std::equal(first.begin(), first.end(), keys.begin(), is_same);
}

LocalScans local_scans(const PlacedScans& keys, const PathUncertainty& ways, double max_sigma) {
  const Eigen::Vector2d here = keys.back().map_from_base.translation();
  const std::vector<std::size_t> soon = keys_within(keys, here, kLocalReach + kLookahead);
  const std::vector<bool> is_apart = ways.weakly_connected(soon, max_sigma);
  LocalScans near;
  near.center = here;
  near.newest = keys.size() - 1;
  for (std::size_t i = 0; i < soon.size(); ++i) {
    const PlacedScan& key = keys[soon[i]];
    if (is_apart[i]) {
      near.apart.push_back(key.scan->id());
    } else if (distance(key, here) < kLocalReach) {
      near.belonging.push_back(key);
    }
  }
  return near;
}

LocalScans without(LocalScans near, const std::vector<std::uint64_t>& ids) {
  const auto is_out = [&ids](const PlacedScan& key) {
    return std::binary_search(ids.begin(), ids.end(), key.scan->id());
  };
  PlacedScans& keys = near.belonging;
  keys.erase(std::remove_if(keys.begin(), keys.end(), is_out), keys.end());
  return near;
}

void LocalMap::renumber(const std::vector<std::size_t>& numbers, std::size_t gone) {
  for (std::uint64_t& id : drawn_) {
    id = numbers.at(id);
  }
  taken_ -= gone;
}

bool LocalMap::is_due(const PlacedScans& keys) const {
  return !map_ || distance(keys.back(), center_) >= kLocalReach / 3.0 ||
         drawn_.size() >= kMaxDrawnScans;
}

LocalMap::LocalMap(const Eigen::Vector2d& center,  // NOLINT(modernize-pass-by-value): two doubles
                   const PlacedScans& drawn, std::size_t taken, const MapOptions& map_options,
                   const LikelihoodFieldOptions& field_options)
    : map_(rendered(drawn, map_options, field_options, MapUse::kMatched)),
      center_(center),
      taken_(taken),
      drawn_(ids_of(drawn)) {}

LocalMap::LocalMap(const LocalScans& near, const MapOptions& map_options,
                   const LikelihoodFieldOptions& field_options)
    : LocalMap(near.center, nearest(near.belonging, near.center), near.newest + 1, map_options,
               field_options) {}

std::optional<LocalMap> LocalMap::with(const LocalScans& near,
                                       const MapOptions& map_options) const {
  const auto is_shown = [shown = std::set(drawn_.begin(), drawn_.end())](std::uint64_t id) {
    return shown.count(id) > 0;
  };
  if (!map_ || drawn_.empty() || drawn_.size() >= kMaxDrawnScans ||
      std::any_of(near.apart.begin(), near.apart.end(), is_shown)) {
    return std::nullopt;
  }
  LocalMap more = *this;
  more.center_ = near.center;
  more.taken_ = near.newest + 1;
  for (const PlacedScan& key : nearest(near.belonging, near.center)) {
    if (is_shown(key.scan->id())) {
      continue;
    }
    if (key.scan->id() < more.drawn_.back() || more.drawn_.size() == kMaxDrawnScans) {
      return std::nullopt;
    }
    more.draw(key, map_options);
  }
  more.map_->field.render();
  return more;
}

LocalMap LocalMap::as_of(std::size_t taken, const PlacedScans& keys, const MapOptions& map_options,
                         const LikelihoodFieldOptions& field_options) const {
  if (!map_) {
    return {};
  }
  PlacedScans then;
  for (const std::uint64_t id : drawn_) {
    if (id < taken) {
      then.push_back(keys[id]);
    }
  }
  return {center_, then, taken, map_options, field_options};
}

void LocalMap::draw(const PlacedScan& key, const MapOptions& map_options) {
  insert_unrendered(*key.scan->points(), key.map_from_base, map_options, MapUse::kMatched, *map_);
  drawn_.push_back(key.scan->id());
}

void LocalMap::take_new(const PlacedScans& keys, const MapOptions& map_options) {
  for (; taken_ < keys.size(); ++taken_) {
    const PlacedScan& key = keys[taken_];
    if (map_ && distance(key, center_) < kLocalReach) {
      draw(key, map_options);
    }
  }
  if (map_) {
    map_->field.render();
  }
}

}  // namespace matchbox_slam
