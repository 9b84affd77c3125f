#include "slam/map_merging.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/graph/optimise.hpp"
#include "matchbox_slam/matching/contradiction.hpp"
#include "matching/rendered_map.hpp"
#include "slam/loop_work.hpp"
#include "slam/map_meeting.hpp"
#include "slam/match_validation.hpp"
#include "slam/path_uncertainty.hpp"
#include "slam/recovery.hpp"

namespace matchbox_slam {
namespace {

void draw(const EngineOptions& options, MapPart& part) {
  part.map = rendered(part.key_scans.all(), options.map, options.field);
}

void move_key_scans(const std::vector<Pose2>& poses, KeyScans& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys.move(i, poses[i]);
  }
}

// --- maps as they are given ---

/// What was begun to be searched takes effect, as where a drive ends.
void finish_loops(const EngineOptions& options, KeyScans& keys, LoopState& state) {
  LoopCloser loops(std::move(state));
  loops.begin_again(keys, {std::nullopt, options.map, options.field, 0}, options.loops);
  if (loops.is_pending()) {
    static_cast<void>(loops.finish(keys));
    move_key_scans(loops.graph().poses, keys);
  }
  state = loops.state();
}

/// Key scans that are in no graph yet are joined as those that wait are.
void join_in_graph(const PlacedScans& added, const EngineOptions& options, KeyScans& keys,
                   LoopState& state) {
  constexpr double kXy = 0.05;     // [m], as Mapping::insert_pending has it
  constexpr double kTheta = 0.02;  // [rad], likewise
  LoopCloser loops(std::move(state));
  for (const PlacedScan& key : added) {
    const bool is_continued = keys.size() > 0;
    keys.add(key);
    loops.add(keys, covariance_of(kXy, kTheta), is_continued, options.loops);
  }
  state = loops.state();
}

/// One of the maps that a state holds: 0 the map, n the n-th one apart.
MergedMap map_of(const EngineState& state, std::size_t input, std::size_t number,
                 const EngineOptions& options) {
  const bool is_map = number == 0;
  const KeyScans& all = is_map ? state.key_scans : state.localization.apart[number - 1].key_scans;
  MergedMap map{{SlamMap(options.map, options.field), {}, {}, 0.0}, {}, {}, {}};
  KeyScans& keys = map.part.key_scans;
  PlacedScans added;
  if (is_map) {
    map.loops = state.loops;
  }
  const std::size_t in_graph = std::min(all.size(), map.loops.graph.poses.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i < in_graph) {
      keys.add(all.all()[i]);
    } else {
      added.push_back(all.all()[i]);
    }
  }
  for (const WaitingScan& waiting : state.localization.pending) {
    if (waiting.part == number) {
      added.push_back(waiting.scan);
    }
  }
  finish_loops(options, keys, map.loops);
  join_in_graph(added, options, keys, map.loops);
  if (!keys.empty()) {
    map.stretches.push_back({input, number, 0, keys.size(), keys.all().front().map_from_base});
  }
  return map;
}

std::vector<MergedMap> maps_of(const std::vector<EngineState>& states,
                               const EngineOptions& options) {
  std::vector<MergedMap> maps;
  for (std::size_t input = 0; input < states.size(); ++input) {
    for (std::size_t number = 0; number <= states[input].localization.apart.size(); ++number) {
      MergedMap map = map_of(states[input], input, number, options);
      if (!map.part.key_scans.empty()) {
        draw(options, map.part);
        maps.push_back(std::move(map));
      }
    }
  }
  return maps;
}

// --- two maps that meet ---

/// Joins a map to another one, in which it was found.
class Joining {
 public:
  Joining(MergedMap& map, MergedMap other, const MapMeeting& meeting, const EngineOptions& options);

  /// From where both meet on, to one end of the other map's key scans and to the other one.
  void join_on();

 private:
  void append(MergedMap other, const Pose2& map_from_other);
  void join_where_found();
  void join_at(std::size_t key);
  void search_loop();
  void optimise_poses();
  [[nodiscard]] PlacedScans up_to(std::size_t key) const;
  PoseGraph& graph() { return map_.loops.graph; }

  MergedMap& map_;
  const EngineOptions& options_;
  std::size_t first_;  ///< key scan of the other map
  std::size_t found_;  ///< the one that was found
  PlacedScans keys_;   ///< up to the one at hand, which counts as the newest
  AdjacencyList links_;
  double way_ = 0.0;  ///< [m] since a loop was searched for
  MergedJoint joint_;
};

Joining::Joining(MergedMap& map, MergedMap other, const MapMeeting& meeting,
                 const EngineOptions& options)
    : map_(map),
      options_(options),
      first_(map.part.key_scans.size()),
      found_(first_ + meeting.key) {
  append(std::move(other), meeting.there_from_map);
}

void Joining::append(MergedMap other, const Pose2& map_from_other) {
  for (const PlacedScan& key : other.part.key_scans.all()) {
    map_.part.key_scans.add({key.scan, map_from_other * key.map_from_base});
  }
  for (const Pose2& pose : other.loops.graph.poses) {
    graph().poses.push_back(map_from_other * pose);
  }
  for (PoseEdge edge : other.loops.graph.edges) {
    edge.from += first_;
    edge.to += first_;
    add_edge(edge, graph());
  }
  for (ClosedLoop loop : other.loops.loops) {
    loop.found.key += first_;
    loop.newest += first_;
    map_.loops.loops.push_back(loop);
  }
  map_.loops.tries += other.loops.tries;
  for (MergedStretch stretch : other.stretches) {
    stretch.begin += first_;
    stretch.end += first_;
    map_.stretches.push_back(stretch);
  }
  map_.joints.insert(map_.joints.end(), other.joints.begin(), other.joints.end());
}

PlacedScans Joining::up_to(std::size_t key) const {
  const PlacedScans& all = map_.part.key_scans.all();
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(key + 1)};
}

/// The edge that makes one graph of two. What is no loop is always believed, as that a lost robot
/// was found.
void Joining::join_where_found() {
  keys_ = up_to(found_);
  const Eigen::Vector2d here = keys_.back().map_from_base.translation();
  const auto nearest =
      std::min_element(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(first_),
                       [&](const PlacedScan& a, const PlacedScan& b) {
                         return distance(a, here) < distance(b, here);
                       });
  const auto there = static_cast<std::size_t>(nearest - keys_.begin());
  const Pose2 there_from_here = nearest->map_from_base.inverse() * keys_.back().map_from_base;
  add_edge({there, found_, there_from_here, covariance_where_found()}, graph());
  joint_.stamp = keys_.back().scan->stamp();
  joint_.stamp_there = nearest->scan->stamp();
}

void Joining::join_on() {
  join_where_found();
  links_.take_new(graph());
  const std::size_t end = map_.part.key_scans.size();
  for (std::size_t key = found_; key < end; ++key) {
    join_at(key);
  }
  way_ = 0.0;
  for (std::size_t key = found_; key-- > first_;) {
    join_at(key);
  }
  optimise_poses();
  map_.joints.push_back(joint_);
  draw(options_, map_.part);
}

/// What mapping does with a new key scan: it is joined to one that lies there already, and now and
/// then a loop is searched for.
void Joining::join_at(std::size_t key) {
  if (key > first_) {
    const PlacedScans& all = map_.part.key_scans.all();
    way_ += way_between(all[key - 1].map_from_base, all[key].map_from_base);
  }
  keys_ = up_to(key);
  const std::optional<FoundLoop> near =
      match_with_earlier(keys_, first_, {graph(), links_, key}, false, options_.loops);
  if (near) {
    add_edge({near->key, key, near->key_from_newest, near->covariance}, graph());
    ++joint_.matched;
  }
  if (way_ >= options_.loops.search_way) {
    way_ = 0.0;
    search_loop();
  }
  links_.take_new(graph());
}

void Joining::search_loop() {
  LoopSearch search{keys_, std::move(graph()), options_.loops};
  LoopTaskDone done;
  close_a_loop(search, kLeastMoved * options_.map.resolution, done);
  graph() = std::move(search.graph);
  joint_.tried += done.tries;
  joint_.closed += count_closed(done.loops);
  map_.loops.tries += done.tries;
  map_.loops.loops.insert(map_.loops.loops.end(), done.loops.begin(), done.loops.end());
  if (done.has_moved) {
    move_key_scans(graph().poses, map_.part.key_scans);
  }
}

void Joining::optimise_poses() {
  graph() = optimise(std::move(graph())).graph;
  move_key_scans(graph().poses, map_.part.key_scans);
}

/// Share of the key scans of some that were taken near others, and see through the walls of those.
double share_through_walls(const PlacedScans& keys, const PlacedScans& others, const SlamMap& map) {
  constexpr double kNear = 2.0;  // [m], as what is matched with lies: a guess
  std::size_t near = 0;
  std::size_t through = 0;
  for (const PlacedScan& key : keys) {
    const Eigen::Vector2d here = key.map_from_base.translation();
    const bool is_near = std::any_of(others.begin(), others.end(), [&](const PlacedScan& other) {
      return distance(other, here) < kNear;
    });
    if (is_near) {
      ++near;
      const double against = contradiction(*key.scan->points(), key.map_from_base, map.field);
      through += against > kMostViolation ? 1 : 0;
    }
  }
  return near > 0 ? static_cast<double>(through) / static_cast<double>(near) : 0.0;
}

/// What a lost robot has seen when it is found is little of what two whole maps tell: joined at the
/// right place neither sees through the other's walls. In a campus of buildings that are alike,
/// where both overlap for 100 m and more, up to 2 % of key scans do at right places and 22 % and
/// more at a wrong one (benchmark/reports/current/MERGING.md).
/// @param first  key scan of the second of both.
bool is_without_contradiction(const PlacedScans& all, std::size_t first,
                              const EngineOptions& options) {
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(first);
  const PlacedScans one(all.begin(), middle);
  const PlacedScans other(middle, all.end());
  return share_through_walls(one, other, rendered(other, options.map, options.field)) <=
             kMostThroughWalls &&
         share_through_walls(other, one, rendered(one, options.map, options.field)) <=
             kMostThroughWalls;
}

/// Two maps as one, unless what they saw contradicts that.
std::optional<MergedMap> joined(const MergedMap& map, const MergedMap& there,
                                const MapMeeting& meeting, const EngineOptions& options) {
  MergedMap both = there;
  Joining(both, map, meeting, options).join_on();
  const std::size_t first = there.part.key_scans.size();
  return is_without_contradiction(both.part.key_scans.all(), first, options)
             ? std::optional(std::move(both))
             : std::nullopt;
}

// --- many ---

/// That of the first input.
const MergedStretch& first_stretch(const MergedMap& map) {
  return *std::min_element(map.stretches.begin(), map.stretches.end(),
                           [](const MergedStretch& a, const MergedStretch& b) {
                             return std::tie(a.input, a.part) < std::tie(b.input, b.part);
                           });
}

/// In an order that does not depend on that of the inputs: what is most certain where it is comes
/// first.
void sort_by_size(std::vector<MergedMap>& maps) {
  const auto rank = [](const MergedMap& map) {
    const PlacedScans& keys = map.part.key_scans.all();
    return std::make_tuple(-static_cast<std::int64_t>(keys.size()), keys.front().scan->stamp(),
                           keys.front().map_from_base.x, keys.front().map_from_base.y);
  };
  std::stable_sort(maps.begin(), maps.end(),
                   [&](const MergedMap& a, const MergedMap& b) { return rank(a) < rank(b); });
}

/// The maps that were searched in each other, by which inputs' parts are in them.
using Searched = std::set<std::pair<std::set<std::pair<std::size_t, std::size_t>>,
                                    std::set<std::pair<std::size_t, std::size_t>>>>;

std::set<std::pair<std::size_t, std::size_t>> parts_of(const MergedMap& map) {
  std::set<std::pair<std::size_t, std::size_t>> parts;
  for (const MergedStretch& stretch : map.stretches) {
    parts.emplace(stretch.input, stretch.part);
  }
  return parts;
}

/// Searches one in the other one, along its way and back. None: it is not found.
std::optional<MergedMap> joined_if_found(const MergedMap& map, const MergedMap& there,
                                         const EngineOptions& options,
                                         const MergeProgress& progress) {
  std::optional<MergedMap> both;
  PlacedScans way = map.part.key_scans.all();
  for (const bool is_back : {false, true}) {
    const auto is_believed = [&](MapMeeting meeting) {
      meeting.key = is_back ? way.size() - 1 - meeting.key : meeting.key;
      both = joined(map, there, meeting, options);
      return both.has_value();
    };
    const auto tell = [&](double done) {
      progress(first_stretch(map).input, first_stretch(there).input,
               0.5 * (done + (is_back ? 1.0 : 0.0)));
    };
    if (find_meeting(way, there.part, options, is_believed, tell)) {
      return both;
    }
    std::reverse(way.begin(), way.end());
  }
  return std::nullopt;
}

/// The smaller one is searched in the larger one first.
bool join_two(const EngineOptions& options, const MergeProgress& progress, Searched& searched,
              std::vector<MergedMap>& maps) {
  for (std::size_t i = 0; i < maps.size(); ++i) {
    for (std::size_t j = i + 1; j < maps.size(); ++j) {
      if (!searched.emplace(parts_of(maps[i]), parts_of(maps[j])).second) {
        continue;
      }
      std::optional<MergedMap> both = joined_if_found(maps[j], maps[i], options, progress);
      if (!both) {
        both = joined_if_found(maps[i], maps[j], options, progress);
      }
      if (both) {
        maps[i] = std::move(*both);
        maps.erase(maps.begin() + static_cast<std::ptrdiff_t>(j));
        return true;
      }
    }
  }
  return false;
}

/// Where the first key scan of the first input is as it was.
void go_to_first_frame(const EngineOptions& options, MergedMap& map) {
  const MergedStretch& first = first_stretch(map);
  std::vector<Pose2>& poses = map.loops.graph.poses;
  const Pose2 new_from_old = first.first * poses[first.begin].inverse();
  for (Pose2& pose : poses) {
    pose = new_from_old * pose;
  }
  move_key_scans(poses, map.part.key_scans);
  draw(options, map.part);
}

}  // namespace

std::vector<MergedMap> merge_maps(const std::vector<EngineState>& states,
                                  const EngineOptions& options, const MergeProgress& progress) {
  std::vector<MergedMap> maps = maps_of(states, options);
  Searched searched;
  sort_by_size(maps);
  while (join_two(options, progress, searched, maps)) {
    sort_by_size(maps);
  }
  std::stable_sort(maps.begin(), maps.end(), [](const MergedMap& a, const MergedMap& b) {
    return first_stretch(a).input < first_stretch(b).input;
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
  EngineState state{std::move(map.part.map), std::move(map.part.key_scans), {}, {}};
  state.motion.fixed_from_base = state.key_scans.all()[first.end - 1].map_from_base;
  state.loops = std::move(map.loops);
  return state;
}

}  // namespace matchbox_slam
