#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// What is left of a graph some of whose nodes were taken out.
struct CondensedGraph {
  PoseGraph graph;
  /// By number of each node before: what its number is now; of one that was taken out, the number
  /// of the node that loops which ended at it end at now.
  std::vector<std::size_t> numbers;
};

/// Takes nodes out, whose edges become edges between their neighbours: what the graph says of the
/// others stays, or is said less surely, and never more. A node between two others leaves the
/// motion from one to the other, which is exact to first order. One of more neighbours leaves a
/// tree, all of them joined to the one that it is joined to most surely (in a star all trees of
/// Chow and Liu 1968 are such); what they have in common, the edge to that one, is shared out among
/// them so that none counts it twice (compare Carlevaris-Bianco and Eustice 2014, Kretzschmar and
/// Stachniss 2012). Loops are handed on as the inliers or outliers that they are. Edges that say
/// the same become one; and there are at most three a node of such edges, the surest, and what
/// holds the graph together.
///
/// The poses stay. Of drift, an edge keeps as much as certainly is one for each share of it that
/// loops may tell. The same graph gives the same bits.
/// @param is_taken  by node: whether it is taken out. Not the first and not the last one.
/// Throws std::invalid_argument for those, and for another number of nodes than the graph has.
[[nodiscard]] CondensedGraph condensed(PoseGraph graph, const std::vector<bool>& is_taken);

}  // namespace matchbox_slam
