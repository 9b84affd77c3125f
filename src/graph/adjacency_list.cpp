#include "graph/adjacency_list.hpp"

#include "common/append.hpp"

namespace matchbox_slam {

void AdjacencyList::take_new(std::size_t nodes, const std::vector<PoseEdge>& edges) {
  first_.resize(nodes, kNone);
  last_.resize(nodes, kNone);
  for (std::size_t edge = ends_.size() / 2; edge < edges.size(); ++edge) {
    for (const std::size_t node : {edges[edge].from, edges[edge].to}) {
      const auto end = static_cast<Number>(ends_.size());
      (first_[node] == kNone ? first_[node] : ends_[last_[node]].next) = end;
      last_[node] = end;
      append_sparingly({static_cast<Number>(node), kNone}, ends_);
    }
  }
}

}  // namespace matchbox_slam
