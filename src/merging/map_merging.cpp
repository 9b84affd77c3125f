#include "merging/map_merging.hpp"

#include <algorithm>
#include <cstdint>
#include <set>
#include <tuple>
#include <utility>

#include "merging/meeting_search.hpp"
#include "slam/loop_closing.hpp"
#include "slam/mapping.hpp"

namespace matchbox_slam {
namespace {

// --- maps as they are given ---

/// What was begun to be searched takes effect, as where a drive ends; all key scans are kept.
void finish_loops(EngineOptions options, KeyScans& keys, LoopState& state) {
  options.slam.enough_views = 0;
  LoopCloser loops(std::move(state));
  loops.begin_again(keys, {}, options);
  if (loops.is_pending()) {
    static_cast<void>(loops.finish(keys));
  }
  state = loops.state();
}

/// A key scan that is in no graph yet is joined as one that comes.
/// @param is_continued  whether it was seen next after the one before.
void join_in_graph(const PlacedScan& key, bool is_continued, const EngineOptions& options,
                   KeyScans& keys, LoopCloser& loops) {
  keys.add(key);
  loops.add(keys, covariance_of_waiting(), is_continued, options.loops);
}

/// One of the maps that a state holds: 0 the map, n the n-th component besides.
MergedMap map_of(const EngineState& state, std::size_t input, std::size_t number,
                 const EngineOptions& options) {
  const bool is_map = number == 0;
  const KeyScans& all =
      is_map ? state.key_scans : state.localization.components[number - 1].key_scans;
  MergedMap map{{SlamMap(options.map, options.field), {}, {}, 0.0}, {}, {}, {}};
  KeyScans& keys = map.component.key_scans;
  if (is_map) {
    map.loops = state.loops;
  }
  const std::size_t in_graph = std::min(all.size(), map.loops.nodes);
  for (std::size_t i = 0; i < in_graph; ++i) {
    keys.add(all.all()[i]);
  }
  finish_loops(options, keys, map.loops);
  LoopCloser loops(std::move(map.loops));
  for (std::size_t i = in_graph; i < all.size(); ++i) {
    join_in_graph(all.all()[i], !keys.empty(), options, keys, loops);
  }
  for (const WaitingScan& waiting : state.localization.pending) {
    if (waiting.component == number) {  // it was seen on another way
      join_in_graph(waiting.scan, false, options, keys, loops);
    }
  }
  map.loops = loops.state();
  if (!keys.empty()) {
    map.stretches.push_back({input, number, 0, keys.size(), keys.all().front().map_from_base});
  }
  return map;
}

std::vector<MergedMap> maps_of(const std::vector<EngineState>& states,
                               const EngineOptions& options) {
  std::vector<MergedMap> all;
  for (std::size_t input = 0; input < states.size(); ++input) {
    for (MergedMap& map : maps_of(states[input], options, input)) {
      all.push_back(std::move(map));
    }
  }
  return all;
}

// --- many ---

/// That of the first input.
const MergedStretch& first_stretch(const MergedMap& map) {
  return *std::min_element(map.stretches.begin(), map.stretches.end(),
                           [](const MergedStretch& a, const MergedStretch& b) {
                             return std::tie(a.input, a.component) < std::tie(b.input, b.component);
                           });
}

/// In an order that does not depend on that of the inputs: what is most certain where it is comes
/// first.
void sort_by_size(std::vector<MergedMap>& maps) {
  const auto rank = [](const MergedMap& map) {
    const PlacedScans& keys = map.component.key_scans.all();
    return std::make_tuple(-static_cast<std::int64_t>(keys.size()), keys.front().scan->stamp(),
                           keys.front().map_from_base.x, keys.front().map_from_base.y);
  };
  std::stable_sort(maps.begin(), maps.end(),
                   [&](const MergedMap& a, const MergedMap& b) { return rank(a) < rank(b); });
}

using Components = std::set<std::pair<std::size_t, std::size_t>>;  ///< of inputs

Components components_of(const MergedMap& map) {
  Components components;
  for (const MergedStretch& stretch : map.stretches) {
    components.emplace(stretch.input, stretch.component);
  }
  return components;
}

/// Of two maps the smaller one is searched in the larger one first.
class Merging {
 public:
  Merging(std::vector<MergedMap> maps, const EngineOptions& options, const MergeProgress& progress)
      : maps_(std::move(maps)), options_(options), progress_(progress) {}

  std::vector<MergedMap> merge() {
    sort_by_size(maps_);
    while (join_two()) {
      sort_by_size(maps_);
    }
    return std::move(maps_);
  }

 private:
  /// Of those that were not searched in each other yet.
  [[nodiscard]] std::vector<MeetingPass> passes() const {
    std::vector<MeetingPass> passes;
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      for (std::size_t j = i + 1; j < maps_.size(); ++j) {
        if (apart_.count({components_of(maps_[i]), components_of(maps_[j])}) == 0) {
          passes.insert(passes.end(), {{j, i, false}, {j, i, true}, {i, j, false}, {i, j, true}});
        }
      }
    }
    return passes;
  }

  bool join_two() {
    const std::vector<MeetingPass> all = passes();
    std::optional<FoundMeeting> found = search_meetings(
        maps_, all, options_, [this](double done) { progress_(maps_.size(), done); });
    // Those of a pair follow each other.
    const std::size_t searched = (found ? found->pass : all.size()) / kPassesOfPair * kPassesOfPair;
    for (std::size_t pass = 0; pass < searched; pass += kPassesOfPair) {
      apart_.emplace(components_of(maps_[all[pass].there]), components_of(maps_[all[pass].map]));
      apart_.emplace(components_of(maps_[all[pass].map]), components_of(maps_[all[pass].there]));
    }
    if (found) {
      const MeetingPass& pass = all[found->pass];
      const std::size_t gone = std::max(pass.map, pass.there);
      maps_[std::min(pass.map, pass.there)] = std::move(found->both);
      draw(options_, maps_[std::min(pass.map, pass.there)].component);
      maps_.erase(maps_.begin() + static_cast<std::ptrdiff_t>(gone));
    }
    return found.has_value();
  }

  static constexpr std::size_t kPassesOfPair = 4;

  std::vector<MergedMap> maps_;
  const EngineOptions& options_;
  const MergeProgress& progress_;
  std::set<std::pair<Components, Components>> apart_;  ///< that do not meet
};

/// Where the first key scan of the first input is as it was.
void go_to_first_frame(const EngineOptions& options, MergedMap& map) {
  const MergedStretch& first = first_stretch(map);
  KeyScans& keys = map.component.key_scans;
  std::vector<Pose2> poses = keys.poses();
  const Pose2 new_from_old = first.first * poses[first.begin].inverse();
  for (Pose2& pose : poses) {
    pose = new_from_old * pose;
  }
  keys.move(poses);
  draw(options, map.component);
}

}  // namespace

std::vector<MergedMap> maps_of(const EngineState& state, const EngineOptions& options,
                               std::size_t input) {
  std::vector<MergedMap> maps;
  for (std::size_t number = 0; number <= state.localization.components.size(); ++number) {
    MergedMap map = map_of(state, input, number, options);
    if (!map.component.key_scans.empty()) {
      draw(options, map.component);
      maps.push_back(std::move(map));
    }
  }
  return maps;
}

std::vector<MergedMap> merged_maps(const std::vector<EngineState>& states,
                                   const EngineOptions& options, const MergeProgress& progress) {
  std::vector<MergedMap> maps = Merging(maps_of(states, options), options, progress).merge();
  std::sort(maps.begin(), maps.end(), [](const MergedMap& a, const MergedMap& b) {
    const MergedStretch& one = first_stretch(a);
    const MergedStretch& other = first_stretch(b);
    return std::tie(one.input, one.component) < std::tie(other.input, other.component);
  });
  for (MergedMap& map : maps) {
    if (map.stretches.size() > 1) {
      go_to_first_frame(options, map);
    }
  }
  return maps;
}

EngineState state_of(MergedMap map) {
  const MergedStretch first = first_stretch(map);
  EngineState state{std::move(map.component.map), std::move(map.component.key_scans), {}, {}};
  state.motion.fixed_from_base = state.key_scans.all()[first.end - 1].map_from_base;
  state.loops = std::move(map.loops);
  return state;
}

}  // namespace matchbox_slam
