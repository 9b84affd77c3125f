#include "matchbox_slam/graph/optimise.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "graph/best_poses.hpp"
#include "graph/compatible_loops.hpp"
#include "graph/edge_error.hpp"
#include "graph/map_drift.hpp"
#include "matchbox_slam/geometry/chi_square.hpp"

namespace matchbox_slam {
namespace {

std::vector<std::size_t> loops_of(const PoseGraph& graph, bool inliers_too) {
  std::vector<std::size_t> loops;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].kind == EdgeKind::kLoop && (inliers_too || !is_used(graph.edges[i]))) {
      loops.push_back(i);
    }
  }
  return loops;
}

std::size_t number_of_inliers(const PoseGraph& graph) {
  return loops_of(graph, true).size() - loops_of(graph, false).size();
}

constexpr double kCoarseTolerance = 1e-3;  // tolerances of the chi-square
constexpr double kFineTolerance = 1e-9;

/// Again and again, since what loops are expected to say is so where the poses are nearly right.
void take_compatible(PoseGraph& graph) {
  while (true) {
    const LoopErrors errors = expect_errors(graph, loops_of(graph, false));
    const auto compatible = compatible_loops(errors, kMostChiSquare);
    for (const std::size_t i : compatible) {
      graph.edges[errors.loops[i]].verdict = LoopVerdict::kInlier;
    }
    if (compatible.empty() || compatible.size() == errors.loops.size()) {
      return;
    }
    move_to_best_poses(graph, kCoarseTolerance);
  }
}

/// Takes in what is compatible with the inliers that there are, and then drops what fits them no
/// more.
void settle(PoseGraph& graph) {
  take_compatible(graph);
  move_to_best_poses(graph, kFineTolerance);
  while (const auto worst = worst_loop(graph, kMostChiSquare)) {
    graph.edges[*worst].verdict = LoopVerdict::kOutlier;
    move_to_best_poses(graph, kFineTolerance);
  }
}

/// Whether there are more inliers when an outlier is taken in first.
void reconsider(PoseGraph& graph) {
  constexpr int kMaxTrials = 8;  // a guess: half and double were not tried
  const LoopErrors errors = expect_errors(graph, loops_of(graph, true), true);
  std::vector<std::size_t> best;
  int tried = 0;
  for (std::size_t i = 0; i < errors.loops.size() && tried < kMaxTrials; ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d error = errors.error.segment<3>(at);
    if (is_used(graph.edges[errors.loops[i]]) ||
        chi_square(error, errors.covariance.block<3, 3>(at, at)) > kMostChiSquare) {
      continue;
    }
    ++tried;
    std::vector<std::size_t> set = compatible_loops(errors, kMostChiSquare, i);
    if (set.size() > best.size()) {
      best = std::move(set);
    }
  }
  const std::size_t inliers_before = number_of_inliers(graph);
  if (best.size() <= inliers_before) {
    return;
  }
  GraphState before = state_of(graph);
  for (const std::size_t loop : errors.loops) {
    graph.edges[loop].verdict = LoopVerdict::kOutlier;
  }
  for (const std::size_t i : best) {
    graph.edges[errors.loops[i]].verdict = LoopVerdict::kInlier;
  }
  settle(graph);
  if (number_of_inliers(graph) <= inliers_before) {
    set_state(std::move(before), graph);
  }
}

}  // namespace

OptimisedGraph optimise(PoseGraph graph) {
  require_sound(graph);
  settle(graph);
  if (std::any_of(graph.edges.begin(), graph.edges.end(), [](const PoseEdge& edge) {
        return edge.kind == EdgeKind::kLoop && edge.verdict == LoopVerdict::kUndecided;
      })) {
    reconsider(graph);
  }
  // Inliers are decided upon with all the drift that is assumed, so that one that comes late is no
  // surprise; the poses are by what there was of it.
  const double share = learn_drift(graph);
  if (share < 1.0) {
    move_to_best_poses(graph, kFineTolerance, share);
  }
  OptimisedGraph result;
  for (PoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoop && !is_used(edge)) {
      edge.verdict = LoopVerdict::kOutlier;
    }
    result.chi_square.push_back(chi_square(edge_error(graph, edge).error, edge.covariance));
  }
  result.graph = std::move(graph);
  return result;
}

}  // namespace matchbox_slam
