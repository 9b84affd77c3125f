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

std::vector<LoopCandidate> candidates_of(const LoopSearch& search) {
  const AdjacencyList links(search.graph);
  return loop_candidates(search.keys, {search.graph, links, search.keys.size() - 1},
                         search.options);
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
void leave_out_superfluous(LocalMapRequest& near, LoopTaskDone& done) {
  constexpr std::size_t kMinTakenOut = 50;
  std::vector<std::uint64_t> ids =
      superfluous_scans(near.scans->all_belonging, near.scans->newest, near.enough);
  if (ids.size() >= kMinTakenOut) {
    near.scans = without(std::move(*near.scans), ids);
    done.superfluous = std::move(ids);
  }
}

void draw_near(const LoopTask& task, LoopTaskDone& done) {
  const LocalMapRequest& near = task.near;
  const LocalScans scans = done.loops.empty() ? *near.scans : local_scans_of(*task.search);
  if (!done.has_moved && done.superfluous.empty()) {
    done.near = near.before.with(scans, near.map);
  }
  if (!done.near) {
    done.near = LocalMap(scans, near.map, near.field);
  }
}

LoopTaskDone do_loop_task(LoopTask task) {
  LoopTaskDone done;
  if (task.search) {
    close_a_loop(*task.search, kMinMoveInCells * task.near.map.resolution, done);
  }
  if (task.near.scans && done.loops.empty()) {
    leave_out_superfluous(task.near, done);
  }
  if (done.has_moved || task.near.scans) {
    draw_near(task, done);
  }
  if (task.search) {
    done.graph = std::move(task.search->graph);
  }
  return done;
}

}  // namespace

LocalScans local_scans_of(const LoopSearch& search) {
  PlacedScans keys = search.keys;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].map_from_base = search.graph.poses[i];
  }
  const AdjacencyList links(search.graph);
  return local_scans(keys, {search.graph, links, keys.size() - 1},
                     search.options.max_relative_sigma);
}

void close_a_loop(LoopSearch& search, double least_moved, LoopTaskDone& done) {
  for (const LoopCandidate& candidate : candidates_of(search)) {
    ++done.tries;
    const std::optional<FoundLoop> found = find_loop(search.keys, candidate, search.options);
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

std::shared_ptr<LoopWork> begin_work(LoopTask task) {
  auto work = [task = std::move(task)]() mutable {
    return std::make_shared<LoopTaskDone>(do_loop_task(std::move(task)));
  };
  return std::make_shared<LoopWork>(LoopWork{std::async(std::launch::async, std::move(work))});
}

LoopTaskDone result_of(const std::shared_ptr<LoopWork>& work) {
  const std::shared_ptr<LoopTaskDone> done = work->done.get();
  if (work.use_count() > 1) {
    return *done;
  }
  return std::move(*done);
}

}  // namespace matchbox_slam
