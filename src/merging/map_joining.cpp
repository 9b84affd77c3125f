#include "merging/map_joining.hpp"

#include <algorithm>
#include <utility>

#include "matchbox_slam/graph/optimise.hpp"
#include "matchbox_slam/motion/motion_prior.hpp"
#include "matching/rendered_map.hpp"
#include "merging/map_agreement.hpp"
#include "slam/loop_closing.hpp"
#include "slam/loop_work.hpp"
#include "slam/path_uncertainty.hpp"

namespace matchbox_slam {
namespace {

/// Joins a map to another one, in which it was found.
class Joining {
 public:
  Joining(MergedMap& map, const MergedMap& other, const MapMeeting& meeting,
          const EngineOptions& options, const std::function<void()>& go_on);

  /// From where both meet on, to one end of the other map's key scans and to the other one.
  void join_on();

 private:
  void append(const MergedMap& other, const Pose2& map_from_other);
  void join_where_found();
  void join_at(std::size_t key);
  void search_loop();
  void optimise_poses();
  void take_keys_up_to(std::size_t key);
  std::vector<PoseEdge>& edges() { return map_.loops.edges; }
  void index_edges() { links_.take_new(map_.loops.nodes, edges()); }

  MergedMap& map_;
  const EngineOptions& options_;
  const std::function<void()>& go_on_;
  std::size_t first_;  ///< key scan of the other map
  std::size_t found_;  ///< the one that was found
  PlacedScans keys_;   ///< up to the one at hand, which counts as the newest
  AdjacencyList links_;
  double way_ = 0.0;  ///< [m] since a loop was searched for
  MergedJoint joint_;
};

Joining::Joining(MergedMap& map, const MergedMap& other, const MapMeeting& meeting,
                 const EngineOptions& options, const std::function<void()>& go_on)
    : map_(map),
      options_(options),
      go_on_(go_on),
      first_(map.component.key_scans.size()),
      found_(first_ + meeting.key) {
  append(other, meeting.there_from_map);
}

void Joining::append(const MergedMap& other, const Pose2& map_from_other) {
  for (const PlacedScan& key : other.component.key_scans.all()) {
    map_.component.key_scans.add({key.scan, map_from_other * key.map_from_base});
  }
  map_.loops.nodes += other.loops.nodes;
  for (PoseEdge edge : other.loops.edges) {
    edge.from += first_;
    edge.to += first_;
    add_edge(edge, edges());
  }
  for (ClosedLoop loop : other.loops.loops) {
    loop.found.key += first_;
    loop.newest += first_;
    map_.loops.loops.push_back(loop);
  }
  map_.loops.tries += other.loops.tries;
  map_.loops.are_others.resize(first_, false);
  map_.loops.are_others.insert(map_.loops.are_others.end(), other.loops.are_others.begin(),
                               other.loops.are_others.end());
  for (MergedStretch stretch : other.stretches) {
    stretch.begin += first_;
    stretch.end += first_;
    map_.stretches.push_back(stretch);
  }
  map_.joints.insert(map_.joints.end(), other.joints.begin(), other.joints.end());
}

/// From one to the next it is one more or one less.
void Joining::take_keys_up_to(std::size_t key) {
  const PlacedScans& all = map_.component.key_scans.all();
  if (keys_.size() == key) {
    keys_.push_back(all[key]);
  } else if (keys_.size() > key + 1) {
    keys_.erase(keys_.begin() + static_cast<std::ptrdiff_t>(key + 1), keys_.end());
  } else if (keys_.size() < key + 1) {
    keys_.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(key + 1));
  }
}

/// The edge that makes one graph of two. What is no loop is no outlier, as that a lost robot
/// was found.
void Joining::join_where_found() {
  take_keys_up_to(found_);
  const Eigen::Vector2d here = keys_.back().map_from_base.translation();
  const auto nearest =
      std::min_element(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(first_),
                       [&](const PlacedScan& a, const PlacedScan& b) {
                         return distance(a, here) < distance(b, here);
                       });
  const auto there = static_cast<std::size_t>(nearest - keys_.begin());
  const Pose2 there_from_here = nearest->map_from_base.inverse() * keys_.back().map_from_base;
  add_edge({there, found_, there_from_here, covariance_where_found()}, edges());
  joint_.stamp = keys_.back().scan->stamp();
  joint_.stamp_there = nearest->scan->stamp();
}

void Joining::join_on() {
  join_where_found();
  index_edges();
  const std::size_t end = map_.component.key_scans.size();
  for (std::size_t key = found_; key < end; ++key) {
    join_at(key);
  }
  way_ = 0.0;
  for (std::size_t key = found_; key-- > first_;) {
    join_at(key);
  }
  optimise_poses();
  map_.joints.push_back(joint_);
}

/// What mapping does with a new key scan: it is joined to those that lie there already, and now and
/// then a loop is searched for.
void Joining::join_at(std::size_t key) {
  go_on_();
  if (key > first_) {
    const PlacedScans& all = map_.component.key_scans.all();
    way_ += way_with_turn(all[key - 1].map_from_base.inverse() * all[key].map_from_base);
  }
  take_keys_up_to(key);
  const std::vector<FoundLoop> near =
      match_with_earlier(keys_, first_, {map_.component.key_scans.poses(), edges(), links_, key},
                         false, options_.loops);
  for (const FoundLoop& one : near) {
    add_edge({one.key, key, one.key_from_newest, one.covariance}, edges());
  }
  joint_.matched += near.empty() ? 0 : 1;
  if (way_ >= kLoopSearchSpacing) {
    way_ = 0.0;
    search_loop();
  }
  index_edges();
}

void Joining::search_loop() {
  KeyScans& all = map_.component.key_scans;
  LoopSearch search{keys_, {all.poses(), std::move(edges())}};
  LoopTaskDone done;
  close_a_loop(options_, search, done);
  edges() = std::move(search.graph.edges);
  joint_.tried += done.tries;
  joint_.closed += count_closed(done.loops);
  map_.loops.tries += done.tries;
  map_.loops.loops.insert(map_.loops.loops.end(), done.loops.begin(), done.loops.end());
  if (done.has_moved) {
    all.move(search.graph.poses);
    keys_.clear();  // to be taken anew
  }
}

void Joining::optimise_poses() {
  KeyScans& all = map_.component.key_scans;
  PoseGraph graph = optimise({all.poses(), std::move(edges())}).graph;
  edges() = std::move(graph.edges);
  all.move(graph.poses);
}

}  // namespace

void draw(const EngineOptions& options, MapComponent& component) {
  component.map = rendered(component.key_scans.all(), options.map, options.field, MapUse::kShown);
}

std::optional<MergedMap> joined(const MergedMap& map, const MergedMap& there,
                                const MapMeeting& meeting, const EngineOptions& options,
                                const std::function<void()>& go_on) {
  MergedMap both{{SlamMap(options.map, options.field), there.component.key_scans, {}, 0.0},
                 there.loops,
                 there.stretches,
                 there.joints};
  Joining(both, map, meeting, options, go_on).join_on();
  const PlacedScans& all = both.component.key_scans.all();
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(there.component.key_scans.size());
  return do_agree({all.begin(), middle}, {middle, all.end()}, options)
             ? std::optional(std::move(both))
             : std::nullopt;
}

}  // namespace matchbox_slam
