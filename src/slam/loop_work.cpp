#include "slam/loop_work.hpp"

#include <algorithm>
#include <utility>

#include "matchbox_slam/graph/optimise.hpp"
#include "slam/loop_search.hpp"
#include "slam/path_uncertainty.hpp"
#include "slam/superfluous_scans.hpp"

namespace matchbox_slam {
namespace {

double most_moved(const PlacedScans& keys, const std::vector<Pose2>& poses) {
  double most = 0.0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Eigen::Vector2d moved = poses[i].translation() - keys[i].map_from_base.translation();
    most = std::max(most, moved.norm());
  }
  return most;
}

std::vector<LoopCandidate> candidates_of(const LoopSearch& search, const LoopOptions& options) {
  const AdjacencyList links(search.graph);
  return loop_candidates(search.keys, {search.graph, links, search.keys.size() - 1}, options);
}

/// Adds a loop to the search's graph, which is left as it was but for the loop unless that is
/// an inlier, and with poses as they were if they hardly move.
/// @param least_moved  [m]
ClosedLoop take_loop(const FoundLoop& found, double least_moved, LoopSearch& search) {
  PoseGraph& graph = search.graph;
  const std::size_t newest = search.keys.size() - 1;
  add_edge({found.key, newest, found.key_from_newest, found.covariance, EdgeKind::kLoop},
           graph.edges);
  GraphState before = state_of(graph);
  OptimisedGraph best = optimise(std::move(graph));
  graph = std::move(best.graph);
  ClosedLoop loop{found, newest, graph.edges.back().verdict == LoopVerdict::kInlier,
                  best.chi_square.back(), 0.0};
  if (!loop.is_inlier) {
    set_state(std::move(before), graph);
    return loop;
  }
  loop.moved = most_moved(search.keys, graph.poses);
  if (loop.moved <= least_moved) {
    graph.poses = std::move(before.poses);
  }
  return loop;
}

/// A few are not worth drawing the map anew.
void leave_out_superfluous(int enough, LocalScans& near, LoopTaskDone& done) {
  constexpr std::size_t kMinTakenOut = 50;
  std::vector<std::uint64_t> ids =
      superfluous_scans(near.belonging, near.newest, static_cast<std::size_t>(enough));
  if (ids.size() >= kMinTakenOut) {
    near = without(std::move(near), ids);
    done.superfluous = std::move(ids);
  }
}

void draw_near(const LoopTask& task, LoopTaskDone& done) {
  const EngineOptions& options = task.options;
  const LocalScans scans =
      done.loops.empty() ? *task.near.scans : local_scans_of(*task.search, options.loops);
  if (!done.has_moved && done.superfluous.empty()) {
    done.near = task.near.before.with(scans, options.map);
  }
  if (!done.near) {
    done.near = LocalMap(scans, options.map, options.field);
  }
}

LoopTaskDone do_loop_task(LoopTask task) {
  LoopTaskDone done;
  std::optional<LocalScans>& near = task.near.scans;
  if (task.search) {
    close_a_loop(task.options, *task.search, done);
  }
  if (near && done.loops.empty()) {
    leave_out_superfluous(task.options.slam.enough_views, *near, done);
  }
  if (near || done.has_moved) {
    draw_near(task, done);
  }
  if (task.search) {
    done.graph = std::move(task.search->graph);
  }
  return done;
}

}  // namespace

LocalScans local_scans_of(const LoopSearch& search, const LoopOptions& options) {
  PlacedScans keys = search.keys;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].map_from_base = search.graph.poses[i];
  }
  const AdjacencyList links(search.graph);
  return local_scans(keys, {search.graph, links, keys.size() - 1}, options.max_relative_sigma);
}

void close_a_loop(const EngineOptions& options, LoopSearch& search, LoopTaskDone& done) {
  const double least_moved = kMinMoveInCells * options.map.resolution;
  for (const LoopCandidate& candidate : candidates_of(search, options.loops)) {
    ++done.tries;
    const std::optional<FoundLoop> found = find_loop(search.keys, candidate, options.loops);
    if (!found) {
      continue;
    }
    done.loops.push_back(take_loop(*found, least_moved, search));
    if (done.loops.back().is_inlier) {
      done.has_moved = done.loops.back().moved > least_moved;
      return;
    }
  }
}

std::future<LoopTaskDone> begin_work(LoopTask task) {
  return std::async(std::launch::async, do_loop_task, std::move(task));
}

}  // namespace matchbox_slam
