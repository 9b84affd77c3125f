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
/// @param least_moved  [m]
void close_a_loop(const LoopSearch& search, double least_moved, LoopTaskDone& done) {
  const std::size_t newest = search.keys.size() - 1;
  const GraphLinks links(search.graph);
  const GraphWays ways(search.graph, links, newest);
  for (const std::size_t candidate : loop_candidates(search.keys, ways, search.options)) {
    ++done.tries;
    const double sigma = std::sqrt(ways.variances({candidate}).front());
    const std::optional<FoundLoop> found = find_loop(search.keys, candidate, sigma, search.options);
    if (!found) {
      continue;
    }
    done.graph.edges.push_back(
        {found->key, newest, found->key_from_newest, found->covariance, EdgeKind::kLoop});
    OptimisedGraph best = optimise(done.graph);
    ClosedLoop loop{*found, newest, best.graph.edges.back().belief == Belief::kBelieved,
                    best.chi_square.back(), 0.0};
    if (loop.believed) {
      loop.moved = most_moved(search.keys, best.graph.poses);
      done.has_moved = loop.moved > least_moved;
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

LoopTaskDone do_loop_task(const LoopTask& task) {
  LoopTaskDone done;
  if (task.search) {
    done.graph.edges.reserve(task.search->graph.edges.size() + 1);  // twice as many else
    done.graph = task.search->graph;
    close_a_loop(*task.search, kLeastMoved * task.near.map.resolution, done);
  }
  if (done.has_moved || task.near.scans) {
    const NearScans scans =
        done.loops.empty() ? *task.near.scans : near_scans_of(*task.search, done.graph);
    done.near = NearMap(scans, task.near.map, task.near.field);
  }
  return done;
}

}  // namespace

NearScans near_scans_of(const LoopSearch& search, const PoseGraph& graph) {
  PlacedScans keys = search.keys;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].map_from_base = graph.poses[i];
  }
  const GraphLinks links(graph);
  const GraphWays ways(graph, links, keys.size() - 1);
  return near_scans(keys, [&](const auto& some) { return ways.apart(some, search.options.apart); });
}

std::shared_ptr<LoopWork> begin_work(LoopTask task) {
  auto work = [task = std::move(task)] {
    return std::make_shared<LoopTaskDone>(do_loop_task(task));
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
