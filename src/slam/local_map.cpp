#include "slam/local_map.hpp"

#include <algorithm>
#include <iterator>
#include <set>

#include "matching/rendered_map.hpp"
#include "slam/local_scans.hpp"

namespace matchbox_slam {
namespace {

// What a robot adds that stays in one room; two and a half times what it is made of. A guess.
constexpr std::size_t kFull = 250;  // key scans

/// In their order.
std::vector<std::uint64_t> ids_of(const PlacedScans& keys) {
  std::vector<std::uint64_t> ids;
  std::transform(keys.begin(), keys.end(), std::back_inserter(ids),
                 [](const PlacedScan& key) { return key.scan->id(); });
  return ids;
}

}  // namespace

void LocalMap::renumber(const std::vector<std::size_t>& numbers, std::size_t gone) {
  for (std::uint64_t& id : drawn_) {
    id = numbers.at(id);
  }
  taken_ -= gone;
}

bool LocalMap::is_due(const PlacedScans& keys) const {
  // A guess, a third of what it reaches. With half loop is 7 % worse, with double 20 %, and aces 7
  // % (CONSTANTS.md).
  constexpr double kMoved = 5.0;  // [m]
  return !map_ || distance(keys.back(), center_) >= kMoved || drawn_.size() >= kFull;
}

LocalMap::LocalMap(const Eigen::Vector2d& center, const PlacedScans& drawn, std::size_t taken,
                   const MapOptions& map_options, const LikelihoodFieldOptions& field_options)
    : map_(rendered(drawn, map_options, field_options)),
      center_(center),
      taken_(taken),
      drawn_(ids_of(drawn)) {}

LocalMap::LocalMap(const LocalScans& near, const MapOptions& map_options,
                   const LikelihoodFieldOptions& field_options)
    : LocalMap(near.center, near.belonging, near.newest + 1, map_options, field_options) {}

std::optional<LocalMap> LocalMap::with(const LocalScans& near,
                                       const MapOptions& map_options) const {
  const auto is_shown = [shown = std::set(drawn_.begin(), drawn_.end())](std::uint64_t id) {
    return shown.count(id) > 0;
  };
  if (!map_ || drawn_.empty() || drawn_.size() >= kFull ||
      std::any_of(near.apart.begin(), near.apart.end(), is_shown)) {
    return std::nullopt;
  }
  LocalMap more = *this;
  more.center_ = near.center;
  more.taken_ = near.newest + 1;
  for (const PlacedScan& key : near.belonging) {
    if (is_shown(key.scan->id())) {
      continue;
    }
    if (key.scan->id() < more.drawn_.back() || more.drawn_.size() == kFull) {
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
  insert_unrendered(*key.scan->points(), key.map_from_base, map_options, *map_);
  drawn_.push_back(key.scan->id());
}

void LocalMap::take_new(const PlacedScans& keys, const MapOptions& map_options) {
  if (taken_ == keys.size()) {
    return;
  }
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
