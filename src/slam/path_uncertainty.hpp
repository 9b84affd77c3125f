#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// Which edges each node of a graph has, used or not. Edges are added as they come, so that nothing
/// has to look at the whole graph for a walk through a part of it.
class AdjacencyList {
 public:
  AdjacencyList() = default;
  explicit AdjacencyList(const PoseGraph& graph) : AdjacencyList(graph.poses.size(), graph.edges) {}
  AdjacencyList(std::size_t nodes, const std::vector<PoseEdge>& edges) { take_new(nodes, edges); }

  /// Takes in the nodes and edges that the graph has had since.
  void take_new(std::size_t nodes, const std::vector<PoseEdge>& edges);

  /// Calls `visit(edge, to)` with the number of each edge of a node and of the node at its other
  /// end, in the order of edges.
  template <typename Visit>
  void for_each(std::size_t node, Visit&& visit) const {
    for (Number end = first_[node]; end != kNone; end = ends_[end].next) {
      visit(std::size_t{end} / 2, std::size_t{ends_[end ^ 1U].node});
    }
  }

 private:
  using Number = std::uint32_t;  ///< small, as copies of long drives have many
  static constexpr Number kNone = std::numeric_limits<Number>::max();
  struct End {
    Number node;
    Number next;  ///< end at the same node
  };

  std::vector<Number> first_;  ///< end at each node
  std::vector<Number> last_;
  std::vector<End> ends_;  ///< two of each edge
};

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
