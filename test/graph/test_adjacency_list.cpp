#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "graph/adjacency_list.hpp"

namespace matchbox_slam {
namespace {

using Links = std::vector<std::pair<std::size_t, std::size_t>>;  ///< edge, node at its other end

PoseEdge between(std::size_t from, std::size_t to) {
  PoseEdge edge;
  edge.from = from;
  edge.to = to;
  return edge;
}

Links links_of(const AdjacencyList& list, std::size_t node) {
  Links links;
  list.for_each(node, [&](std::size_t edge, std::size_t to) { links.emplace_back(edge, to); });
  return links;
}

TEST(AdjacencyList, HasTheEdgesOfANodeInTheirOrder) {
  const AdjacencyList list(4, {between(0, 1), between(1, 2), between(3, 1), between(0, 3)});
  EXPECT_EQ(links_of(list, 0), (Links{{0, 1}, {3, 3}}));
  EXPECT_EQ(links_of(list, 1), (Links{{0, 0}, {1, 2}, {2, 3}}));
  EXPECT_EQ(links_of(list, 2), (Links{{1, 1}}));
  EXPECT_EQ(links_of(list, 3), (Links{{2, 1}, {3, 0}}));
}

TEST(AdjacencyList, TakesInWhatCameSince) {
  std::vector<PoseEdge> edges{between(0, 1)};
  AdjacencyList list(2, edges);
  edges.push_back(between(1, 2));
  edges.push_back(between(2, 0));
  list.take_new(4, edges);
  EXPECT_EQ(links_of(list, 0), (Links{{0, 1}, {2, 2}}));
  EXPECT_EQ(links_of(list, 1), (Links{{0, 0}, {1, 2}}));
  EXPECT_EQ(links_of(list, 2), (Links{{1, 1}, {2, 0}}));
  EXPECT_EQ(links_of(list, 3), Links{});
}

}  // namespace
}  // namespace matchbox_slam
