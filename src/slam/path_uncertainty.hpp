#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "graph/adjacency_list.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// How near nodes are to one of them in the graph, along edges that are used. Looks at edges and
/// links as long as it lives, and follows no more edges than it takes to answer.
class PathUncertainty {
 public:
  /// @param poses  of the graph's nodes.
  PathUncertainty(std::vector<Pose2> poses, const std::vector<PoseEdge>& edges,
                  const AdjacencyList& links, std::size_t node)
      : poses_(std::move(poses)), edges_(&edges), links_(&links), node_(node) {}
  PathUncertainty(const PoseGraph& graph, const AdjacencyList& links, std::size_t node)
      : PathUncertainty(graph.poses, graph.edges, links, node) {}

  /// Variance [m^2] of where each of some nodes is, by the surest way: each edge adds the variance
  /// of its translation, and that of its heading times the square of its distance (Dijkstra 1959).
  /// Never less than what the whole graph says.
  /// @param enough  [m^2] nodes that are known worse than that have an infinite one.
  [[nodiscard]] std::vector<double> variances(
      const std::vector<std::size_t>& nodes,
      double enough = std::numeric_limits<double>::infinity()) const;

  /// Whether each of some nodes lies apart: hardly known where, and far in the graph.
  /// @param sigma  [m] from which on a place is hardly known.
  [[nodiscard]] std::vector<bool> weakly_connected(const std::vector<std::size_t>& nodes,
                                                   double sigma) const;

 private:
  [[nodiscard]] std::vector<double> lengths_within_reach() const;
  [[nodiscard]] double variance_of(const PoseEdge& edge, const Eigen::Vector2d& here) const;

  std::vector<Pose2> poses_;
  const std::vector<PoseEdge>* edges_;
  const AdjacencyList* links_;
  std::size_t node_;
};

}  // namespace matchbox_slam
