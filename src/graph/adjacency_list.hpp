#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
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

}  // namespace matchbox_slam
