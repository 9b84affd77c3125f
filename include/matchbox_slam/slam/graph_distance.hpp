#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// How near nodes are to one of them in the graph, along edges that are used.
struct GraphWays {
  /// Variance [m^2] of where each node is, by the surest way: each edge adds the variance of its
  /// translation, and that of its heading times the square of its distance (Dijkstra 1959). Never
  /// less than what the whole graph says.
  std::vector<double> variances;
  std::vector<std::size_t> edges;  ///< of the way with the fewest
  std::vector<double> lengths;     ///< [m] of that way
};

[[nodiscard]] GraphWays ways_from(const PoseGraph& graph, std::size_t node);

/// Whether each node lies apart from that one: hardly known where, and far in the graph.
/// @param sigma  [m] from which on a place is hardly known.
[[nodiscard]] std::vector<bool> apart(const GraphWays& ways, double sigma);

}  // namespace matchbox_slam
