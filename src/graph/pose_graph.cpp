#include "matchbox_slam/graph/pose_graph.hpp"

#include <Eigen/Cholesky>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/append.hpp"
#include "graph/edge_error.hpp"
#include "graph/joined_nodes.hpp"
#include "graph/map_drift.hpp"

namespace matchbox_slam {
namespace {

std::string name_of(const PoseEdge& edge) {
  return std::string(edge.kind == EdgeKind::kLoop ? "the loop" : "the edge") + " from node " +
         std::to_string(edge.from) + " to node " + std::to_string(edge.to);
}

[[noreturn]] void fail(const std::string& text) {
  throw std::invalid_argument("pose graph: " + text);
}

/// Whether it is a covariance still with the least of its drift.
bool has_room_for_drift(const PoseEdge& edge) {
  return covariance_with_drift(edge, kLeastDriftShare).llt().info() == Eigen::Success;
}

void require_sound(const PoseEdge& edge, std::size_t nodes) {
  if (edge.from >= nodes || edge.to >= nodes) {
    fail(name_of(edge) + " ends at a node that there is not; there are " + std::to_string(nodes));
  }
  if (edge.from == edge.to) {
    fail(name_of(edge) + " joins it to itself");
  }
  if (!edge.from_to.is_finite()) {
    fail(name_of(edge) + " measured a pose that is not finite");
  }
  const Eigen::Matrix3d& covariance = edge.covariance;
  if (!covariance.allFinite() || !covariance.isApprox(covariance.transpose(), 1e-9) ||
      covariance.llt().info() != Eigen::Success) {
    fail(name_of(edge) + " has a covariance that is not finite, symmetric and positive definite");
  }
  if (!(edge.drift.array() >= 0.0).all() || !has_room_for_drift(edge)) {
    fail(name_of(edge) + " has a drift that is not a part of its covariance");
  }
}

}  // namespace

void add_edge(const PoseEdge& edge, std::vector<PoseEdge>& edges) { append_sparingly(edge, edges); }

GraphState state_of(const PoseGraph& graph) {
  GraphState state{graph.poses, {}};
  state.verdicts.reserve(graph.edges.size());
  for (const PoseEdge& edge : graph.edges) {
    state.verdicts.push_back(edge.verdict);
  }
  return state;
}

void set_state(GraphState state, PoseGraph& graph) {
  graph.poses = std::move(state.poses);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    graph.edges[i].verdict = state.verdicts[i];
  }
}

void require_sound(const PoseGraph& graph) {
  if (graph.poses.empty()) {
    fail("it has no nodes");
  }
  for (std::size_t node = 0; node < graph.poses.size(); ++node) {
    if (!graph.poses[node].is_finite()) {
      fail("the pose of node " + std::to_string(node) + " is not finite");
    }
  }
  JoinedNodes joined(graph.poses.size());
  for (const PoseEdge& edge : graph.edges) {
    require_sound(edge, graph.poses.size());
    if (edge.kind != EdgeKind::kLoop) {
      static_cast<void>(joined.join(edge.from, edge.to));
    }
  }
  for (std::size_t node = 1; node < graph.poses.size(); ++node) {
    if (!joined.are_joined(node, 0)) {
      fail("no edges of motion join node " + std::to_string(node) + " to the first one");
    }
  }
}

}  // namespace matchbox_slam
