#include "slam/loop_closing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "graph/condensed_graph.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/motion/motion_prior.hpp"
#include "slam/found_map.hpp"
#include "slam/local_map.hpp"
#include "slam/loop_search.hpp"
#include "slam/slip_inflation.hpp"

namespace matchbox_slam {
namespace {

// What was begun takes effect with the first key scan that was taken so far on, or is so many
// later: at a metre a second most searches are done by then. (Not by stamps: of some logs they are
// made up.)
constexpr double kDelayWay = 0.5;  // [m]
constexpr std::size_t kMostDelay = 5;

}  // namespace

Eigen::Matrix3d covariance_where_found() {
  constexpr double kSigmaXy = 0.1;      // [m], a guess, as the next
  constexpr double kSigmaTheta = 0.05;  // [rad]
  return covariance_of(kSigmaXy, kSigmaTheta);
}

std::vector<FoundLoop> match_with_earlier(const PlacedScans& keys, std::size_t before,
                                          const PathUncertainty& ways, bool may_be_apart,
                                          const LoopOptions& options) {
  // Guesses, with what they gain (benchmark/reports/current/WEAK_DIRECTIONS.md).
  constexpr double kMaxDistance = 3.0;      // [m]
  constexpr std::size_t kMinVisitGap = 15;  // key scans
  constexpr std::size_t kMaxVisits = 4;
  const Eigen::Vector2d here = keys.back().map_from_base.translation();
  std::vector<std::size_t> within = keys_within(keys, here, kMaxDistance);
  within.erase(std::lower_bound(within.begin(), within.end(), before), within.end());
  const std::vector<bool> is_apart = ways.weakly_connected(within, options.max_relative_sigma);
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < within.size(); ++i) {
    if (!is_apart[i] || may_be_apart) {
      near.emplace_back(distance(keys[within[i]], here), within[i]);
    }
  }
  std::vector<FoundLoop> found;
  for (const std::size_t key : nearest_of_each_visit(std::move(near), kMinVisitGap, kMaxVisits)) {
    if (const std::optional<FoundLoop> one = find_near(keys, key)) {
      found.push_back(*one);
    }
  }
  for (FoundLoop& one : found) {  // they share the errors of the newest scan, and weigh as one
    one.covariance *= static_cast<double>(found.size());
  }
  return found;
}

std::vector<Pose2> moved_with(std::vector<Pose2> first, const PlacedScans& keys) {
  const std::size_t then = first.size();
  const Pose2 new_from_old = first.back() * keys[then - 1].map_from_base.inverse();
  for (std::size_t i = then; i < keys.size(); ++i) {
    first.push_back(new_from_old * keys[i].map_from_base);
  }
  return first;
}

LoopCloser::LoopCloser(LoopState state) : state_(std::move(state)) { index_edges(); }

PoseGraph graph_of(const KeyScans& keys, const LoopState& state) {
  return {keys.poses(state.nodes), state.edges};
}

PoseGraph graph_as_of(const PendingLoopWork& begun, const KeyScans& keys, const LoopState& state) {
  return {keys.poses(begun.newest + 1),
          {state.edges.begin(), state.edges.begin() + static_cast<std::ptrdiff_t>(begun.edges)}};
}

std::size_t count_closed(const std::vector<ClosedLoop>& loops) {
  return static_cast<std::size_t>(std::count_if(
      loops.begin(), loops.end(), [](const ClosedLoop& loop) { return loop.is_inlier; }));
}

void LoopCloser::add(const KeyScans& keys, const Eigen::Matrix3d& map_covariance, bool is_continued,
                     const LoopOptions& options) {
  constexpr double kWay = 1.0;  // [m], how well it is known how the robot came there: a guess
  constexpr double kWayHeading = 0.2;  // [rad], likewise
  const PlacedScans& all = keys.all();
  const std::size_t newest = all.size() - 1;
  while (state_.nodes < newest) {
    join_rigidly(all);
  }
  Eigen::Matrix3d covariance = map_covariance;
  if (!is_continued) {
    covariance += covariance_where_found();
  }
  join_to_before(all, covariance, options);
  const std::size_t way = state_.edges.size() - 1;
  links_.take_new(state_.nodes, state_.edges);
  if (newest > 0 && !is_pending()) {
    inflate_for_slip(all, newest - 1, state_.edges);
  }
  if (join_to_earlier(keys, is_continued, options) && !is_continued) {
    // What is wrong about the place goes to the way there, and not to all ways before it.
    state_.edges[way].covariance += covariance_of(kWay, kWayHeading);
  }
}

void LoopCloser::move_since(std::size_t first, const KeyScans& keys) {
  constexpr double kSigmaXy = 0.3;  // [m], how well it is known how the robot came there: a guess
  constexpr double kSigmaTheta = 0.1;  // [rad], likewise
  const PlacedScans& all = keys.all();
  std::vector<PoseEdge>& edges = state_.edges;
  const auto is_refuted = [first](const PoseEdge& edge) {
    return edge.to >= first && (edge.kind == EdgeKind::kLoop || edge.from + 1 != edge.to);
  };
  edges.erase(std::remove_if(edges.begin(), edges.end(), is_refuted), edges.end());
  for (PoseEdge& edge : edges) {
    if (edge.to >= first) {
      edge.from_to = all[edge.from].map_from_base.inverse() * all[edge.to].map_from_base;
    }
    if (edge.to == first) {
      edge.covariance += covariance_of(kSigmaXy, kSigmaTheta);
    }
  }
  index_edges();
}

void LoopCloser::forget_since(std::size_t first) {
  if (first >= state_.nodes) {
    return;
  }
  const auto is_gone = [first](const PoseEdge& edge) {
    return std::max(edge.from, edge.to) >= first;
  };
  std::vector<PoseEdge>& edges = state_.edges;
  edges.erase(std::remove_if(edges.begin(), edges.end(), is_gone), edges.end());
  state_.nodes = first;
  index_edges();
}

/// Of a map that comes without its graph nobody knows how it drifted: it stays as it is.
void LoopCloser::join_rigidly(const PlacedScans& keys) {
  // So little that no loop bends it, and not nothing, as information is its inverse.
  constexpr double kSigmaXy = 1e-3;     // [m]
  constexpr double kSigmaTheta = 1e-4;  // [rad]
  const std::size_t node = state_.nodes++;
  if (node > 0) {
    const Pose2 moved = keys[node - 1].map_from_base.inverse() * keys[node].map_from_base;
    add_edge({node - 1, node, moved, covariance_of(kSigmaXy, kSigmaTheta)}, state_.edges);
  }
}

void LoopCloser::join_to_before(const PlacedScans& keys, const Eigen::Matrix3d& map_covariance,
                                const LoopOptions& options) {
  const std::size_t node = state_.nodes++;
  if (node == 0) {
    return;
  }
  constexpr double kLeastWay = 0.01;  // [m], so that no covariance is nothing
  const Pose2& before = keys[node - 1].map_from_base;
  const Pose2 moved = before.inverse() * keys[node].map_from_base;
  const double way = std::max(kLeastWay, way_with_turn(moved));
  state_.way += way;
  const Eigen::Matrix3d drift = way * covariance_of(options.drift_xy, options.drift_theta);
  PoseEdge edge{node - 1, node, moved, drift + in_turned_frame(map_covariance, before.theta)};
  edge.drift = drift.diagonal();
  add_edge(edge, state_.edges);
}

/// What is matched with belongs together from now on, too; and what lies where the robot was found.
/// Whether there are such key scans.
bool LoopCloser::join_to_earlier(const KeyScans& keys, bool is_continued,
                                 const LoopOptions& options) {
  constexpr std::size_t kNewestSkipped = 30;  // key scans: a guess
  const std::size_t newest = keys.size() - 1;
  const std::size_t since = is_continued ? kNewestSkipped : 0;
  const std::vector<FoundLoop> found = match_with_earlier(
      keys.all(), newest - std::min(newest, since), ways(keys), !is_continued, options);
  for (const FoundLoop& one : found) {
    add_edge({one.key, newest, one.key_from_newest, one.covariance}, state_.edges);
  }
  links_.take_new(state_.nodes, state_.edges);
  return !found.empty();
}

void LoopCloser::begin(const KeyScans& keys, LocalMapRequest near, const EngineOptions& options) {
  if (is_pending()) {
    return;
  }
  const bool is_search_due = state_.way >= kLoopSearchSpacing &&
                             !loop_candidates(keys.all(), ways(keys), options.loops).empty();
  if (!is_search_due && !near.scans) {
    return;
  }
  const PendingLoopWork begun{keys.size() - 1, state_.edges.size(), is_search_due,
                              near.scans.has_value()};
  LoopTask task{options, std::move(near)};
  if (is_search_due) {
    task.search = LoopSearch{keys.all(), graph_of(keys, state_)};
  }
  work_ = begin_work(std::move(task));
  state_.pending = begun;
  state_.way = is_search_due ? 0.0 : state_.way;
}

void LoopCloser::begin_again(const KeyScans& keys, const LocalMap& local_map,
                             const EngineOptions& options) {
  if (!is_pending() || work_.valid()) {
    return;
  }
  const PendingLoopWork& pending = *state_.pending;
  if (pending.newest >= keys.size()) {
    state_.pending.reset();  // of a map that is gone on with without its key scans
    return;
  }
  const std::size_t nodes = pending.newest + 1;
  LoopSearch then{{keys.all().begin(), keys.all().begin() + static_cast<std::ptrdiff_t>(nodes)},
                  graph_as_of(pending, keys, state_)};
  LoopTask task{options, {}};
  if (pending.is_near_due) {
    task.near = {local_scans_of(then, options.loops),
                 local_map.as_of(nodes, keys.all(), options.map, options.field)};
  }
  if (pending.is_search_due) {
    task.search = std::move(then);
  }
  work_ = begin_work(std::move(task));
}

bool LoopCloser::is_due(const KeyScans& keys) const {
  const PlacedScans& all = keys.all();
  const std::optional<PendingLoopWork>& pending = state_.pending;
  return pending &&
         (all.size() > pending->newest + kMostDelay ||
          distance(all[pending->newest], all.back().map_from_base.translation()) >= kDelayWay);
}

LoopCloser::Result LoopCloser::finish(KeyScans& keys) {
  const PendingLoopWork pending = *std::exchange(state_.pending, std::nullopt);
  LoopTaskDone done = work_.get();
  if (pending.is_abandoned) {
    inflate_for_slips(keys.all(), pending.newest);
    return {};
  }
  Result result{std::nullopt, std::move(done.near), std::move(done.superfluous)};
  state_.tries += done.tries;
  std::optional<std::vector<Pose2>> moved;
  if (done.has_moved) {
    moved = moved_with(std::move(done.graph.poses), keys.all());
  }
  if (!done.loops.empty()) {
    take_loops(std::move(done), pending);
  }
  inflate_for_slips(keys.all(), pending.newest);
  if (moved) {
    result.correction = correction_of(keys.all(), *moved);
    keys.move(*moved);
  }
  return result;
}

void LoopCloser::take_loops(LoopTaskDone done, const PendingLoopWork& pending) {
  std::vector<PoseEdge> since = std::move(state_.edges);
  state_.edges = std::move(done.graph.edges);
  for (std::size_t i = pending.edges; i < since.size(); ++i) {
    add_edge(since[i], state_.edges);
  }
  index_edges();
  state_.loops.insert(state_.loops.end(), done.loops.begin(), done.loops.end());
}

/// That end at this key scan or later: while work was under way, which has a copy of the graph, the
/// graph that it was begun with stayed as it was.
void LoopCloser::inflate_for_slips(const PlacedScans& keys, std::size_t since) {
  for (std::size_t key = since; key + 1 < keys.size(); ++key) {
    inflate_for_slip(keys, key, state_.edges);
  }
}

MapCorrection LoopCloser::correction_of(const PlacedScans& keys,
                                        const std::vector<Pose2>& new_map_from_base) const {
  MapCorrection correction;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i < state_.are_others.size() && state_.are_others[i]) {
      continue;
    }
    const Pose2 new_from_old = new_map_from_base[i] * keys[i].map_from_base.inverse();
    correction.steps.push_back({keys[i].scan->stamp(), new_from_old});
  }
  correction.newest = correction.steps.back().new_from_old;
  // What was mapped by a lost robot came later into the map than it was seen.
  std::stable_sort(correction.steps.begin(), correction.steps.end(),
                   [](const auto& a, const auto& b) { return a.since < b.since; });
  return correction;
}

MapCorrection LoopCloser::take_in(const FoundMap& found, KeyScans& keys) {
  const std::vector<Pose2> moved = moved_with(found.own_moved(), keys.all());
  MapCorrection correction = correction_of(keys.all(), moved);
  keys.move(moved);
  keys.insert(1, others_of(found));
  state_.nodes = keys.size();
  state_.edges = edges_with(found, state_.edges);
  index_edges();
  state_.loops = loops_with(found, std::move(state_.loops));
  state_.tries += found.both_loops.tries - found.tries;
  std::vector<bool>& are_others = state_.are_others;
  are_others.resize(std::max<std::size_t>(are_others.size(), 1), false);
  are_others.insert(are_others.begin() + 1, found.others(), true);
  return correction;
}

std::vector<std::size_t> LoopCloser::take_out(const std::vector<bool>& is_taken, KeyScans& keys) {
  std::vector<bool> are_others;
  for (std::size_t i = 0; i < state_.are_others.size(); ++i) {
    if (!is_taken[i]) {
      are_others.push_back(state_.are_others[i]);
    }
  }
  state_.are_others = std::move(are_others);
  CondensedGraph left = condensed({keys.poses(), std::move(state_.edges)}, is_taken);
  keys.take_out(is_taken);
  state_.nodes = keys.size();
  state_.edges = std::move(left.graph.edges);
  index_edges();
  for (ClosedLoop& loop : state_.loops) {
    loop.found.key = left.numbers[loop.found.key];
    loop.newest = left.numbers[loop.newest];
  }
  return std::move(left.numbers);
}

void LoopCloser::abandon() {
  if (state_.pending) {
    state_.pending->is_abandoned = true;
  }
}

}  // namespace matchbox_slam
