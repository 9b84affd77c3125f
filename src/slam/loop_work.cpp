#include "slam/loop_work.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/graph/optimise.hpp"
#include "matchbox_slam/slam/graph_distance.hpp"
#include "slam/loop_search.hpp"

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

/// Searches the candidates until one loop is believed.
void close_a_loop(const LoopTask& task, LoopTaskDone& done) {
  const std::size_t newest = task.keys.size() - 1;
  const GraphLinks links(task.graph);
  const GraphWays ways(task.graph, links, newest);
  for (const std::size_t candidate : loop_candidates(task.keys, ways, task.options)) {
    ++done.tries;
    const double sigma = std::sqrt(ways.variances({candidate}).front());
    const std::optional<FoundLoop> found = find_loop(task.keys, candidate, sigma, task.options);
    if (!found) {
      continue;
    }
    done.graph.edges.push_back(
        {found->key, newest, found->key_from_newest, found->covariance, EdgeKind::kLoop});
    OptimisedGraph best = optimise(done.graph);
    ClosedLoop loop{*found, newest, best.graph.edges.back().belief == Belief::kBelieved,
                    best.chi_square.back(), 0.0};
    if (loop.believed) {
      loop.moved = most_moved(task.keys, best.graph.poses);
      done.has_moved = loop.moved > kLeastMoved * task.near.map.resolution;
      done.graph.edges = std::move(best.graph.edges);
      if (done.has_moved) {
        done.graph.poses = std::move(best.graph.poses);
      }
    }
    done.loops.push_back(loop);
    if (loop.believed) {
      return;
    }
  }
}

NearMap rendered_near(const LoopTask& task, const PoseGraph& graph) {
  PlacedScans keys = task.keys;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].map_from_base = graph.poses[i];
  }
  const GraphLinks links(graph);
  const GraphWays ways(graph, links, keys.size() - 1);
  const auto are_apart = [&](const auto& some) { return ways.apart(some, task.options.apart); };
  return {near_scans(keys, are_apart), keys, task.near.map, task.near.field};
}

}  // namespace

LoopTaskDone do_loop_task(const LoopTask& task) {
  LoopTaskDone done;
  done.graph = task.graph;
  if (task.is_search_due) {
    close_a_loop(task, done);
  }
  if (done.has_moved || task.near.is_due) {
    done.near = rendered_near(task, done.graph);
  }
  return done;
}

}  // namespace matchbox_slam
