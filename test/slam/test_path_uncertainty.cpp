#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "slam/path_uncertainty.hpp"

namespace matchbox_slam {
namespace {

Eigen::Matrix3d diagonal_covariance(double x, double y, double theta) {
  return Eigen::Vector3d(x * x, y * y, theta * theta).asDiagonal();
}

PoseEdge edge(std::size_t from, std::size_t to, const Eigen::Matrix3d& covariance,
              EdgeKind kind = EdgeKind::kMotion, LoopVerdict verdict = LoopVerdict::kUndecided) {
  return {from, to, {}, covariance, kind, verdict};
}

/// Nodes a metre apart along x, each joined to the one before.
PoseGraph chain(std::size_t nodes, const Eigen::Matrix3d& covariance) {
  PoseGraph graph;
  for (std::size_t i = 0; i < nodes; ++i) {
    graph.poses.push_back({1.0 * static_cast<double>(i), 0.0, 0.3});
    if (i > 0) {
      graph.edges.push_back(edge(i - 1, i, covariance));
    }
  }
  return graph;
}

std::vector<std::size_t> all_of(const PoseGraph& graph) {
  std::vector<std::size_t> nodes(graph.poses.size());
  std::iota(nodes.begin(), nodes.end(), 0U);
  return nodes;
}

std::vector<double> variances_from(std::size_t node, const PoseGraph& graph) {
  const AdjacencyList links(graph);
  return PathUncertainty(graph, links, node).variances(all_of(graph));
}

std::vector<bool> apart_from(std::size_t node, const PoseGraph& graph, double sigma) {
  const AdjacencyList links(graph);
  return PathUncertainty(graph, links, node).weakly_connected(all_of(graph), sigma);
}

/// An edge that stands for many is no short way between both its ends.
TEST(GraphDistance, OfWhatWasCondensedIsThatOfItsDrift) {
  PoseGraph graph = chain(3, diagonal_covariance(1.0, 1.0, 0.1));  // 1 m^2: 2.5 km of drift
  EXPECT_EQ(apart_from(2, graph, 0.25), (std::vector<bool>{false, false, false}));
  for (PoseEdge& one : graph.edges) {
    one.kind = EdgeKind::kCondensed;
  }
  EXPECT_EQ(apart_from(2, graph, 0.25), (std::vector<bool>{true, true, false}));
  for (PoseEdge& one : graph.edges) {
    one.covariance = diagonal_covariance(0.02, 0.02, 0.001);  // a metre
  }
  EXPECT_EQ(apart_from(2, graph, 1e-6), (std::vector<bool>{false, false, false}));
}

TEST(GraphDistance, AddsUpAlongAChain) {
  const std::vector<double> variances =
      variances_from(4, chain(6, diagonal_covariance(0.3, 0.1, 1e-9)));
  const std::vector<double> edges = {4, 3, 2, 1, 0, 1};
  for (std::size_t i = 0; i < edges.size(); ++i) {  // a place is as unsure as x and y on average
    EXPECT_NEAR(variances[i], 0.05 * edges[i], 1e-12);
  }
}

TEST(GraphDistance, HeadingCountsByTheLever) {
  const std::vector<double> variances =
      variances_from(3, chain(4, diagonal_covariance(1e-9, 1e-9, 0.1)));
  EXPECT_NEAR(variances[2], 0.01 * 1.0, 1e-12);
  EXPECT_NEAR(variances[1], 0.01 * (1.0 + 4.0), 1e-12);
  EXPECT_NEAR(variances[0], 0.01 * (1.0 + 4.0 + 9.0), 1e-12);
}

TEST(GraphDistance, OnlyLoopsThatAreBelievedShorten) {
  const Eigen::Matrix3d covariance = diagonal_covariance(0.1, 0.1, 1e-9);
  for (const LoopVerdict verdict :
       {LoopVerdict::kUndecided, LoopVerdict::kInlier, LoopVerdict::kOutlier}) {
    PoseGraph graph = chain(60, covariance);
    graph.edges.push_back(edge(1, 59, covariance, EdgeKind::kLoop, verdict));
    const std::size_t to_first = verdict == LoopVerdict::kInlier ? 2 : 59;
    EXPECT_NEAR(variances_from(59, graph)[0], 0.01 * static_cast<double>(to_first), 1e-12);
    EXPECT_EQ(apart_from(59, graph, 0.1)[0], verdict != LoopVerdict::kInlier);
  }
}

TEST(GraphDistance, WhatIsKnownWorseThanEnoughIsNotLookedFor) {
  const PoseGraph graph = chain(10, diagonal_covariance(0.1, 0.1, 1e-9));
  const AdjacencyList links(graph);
  const std::vector<double> variances =
      PathUncertainty(graph, links, 9).variances({2, 7, 0, 7}, 0.025);
  EXPECT_NEAR(variances[1], 0.02, 1e-12);
  EXPECT_NEAR(variances[3], 0.02, 1e-12);
  EXPECT_EQ(variances[0], std::numeric_limits<double>::infinity());
  EXPECT_EQ(variances[2], std::numeric_limits<double>::infinity());
}

/// How many nodes of a chain lie together with its last one, though their places are hardly known.
std::size_t together(std::size_t nodes, double spacing) {
  PoseGraph graph = chain(nodes, diagonal_covariance(10.0, 10.0, 1.0));
  for (PoseEdge& edge : graph.edges) {
    edge.from_to = {spacing, 0.0, 0.0};
  }
  const std::vector<bool> is_apart = apart_from(nodes - 1, graph, 0.1);
  return static_cast<std::size_t>(std::count(is_apart.begin(), is_apart.end(), false));
}

TEST(GraphDistance, ALongWayIsFarHoweverFewItsKeyScans) {
  EXPECT_EQ(together(100, 0.3), 41U);
  EXPECT_EQ(together(100, 1.4), 41U);
  EXPECT_EQ(together(100, 3.0), 21U);
  EXPECT_EQ(together(100, 25.0), 3U);
}

TEST(GraphDistance, TheSurestWayMayHaveMoreEdges) {
  PoseGraph graph = chain(60, diagonal_covariance(0.1, 0.1, 1e-9));
  graph.edges.push_back(edge(0, 59, diagonal_covariance(5.0, 5.0, 1e-9)));
  EXPECT_NEAR(variances_from(59, graph)[0], 59.0 * 0.01, 1e-12);
  EXPECT_FALSE(apart_from(59, graph, 0.1)[0]) << "by one edge it is near";
}

struct Ways {
  std::vector<double> variances;
  std::vector<double> edges;
};

/// By relaxing every edge as often as there are nodes (Bellman and Ford).
Ways by_force(const PoseGraph& graph, std::size_t node) {
  const std::size_t nodes = graph.poses.size();
  std::vector<double> variances(nodes, std::numeric_limits<double>::infinity());
  std::vector<double> edges(nodes, std::numeric_limits<double>::infinity());
  variances[node] = edges[node] = 0.0;
  for (std::size_t round = 0; round < nodes; ++round) {
    for (const PoseEdge& edge : graph.edges) {
      if (edge.kind == EdgeKind::kLoop && edge.verdict != LoopVerdict::kInlier) {
        continue;
      }
      const double lever = std::hypot(graph.poses[edge.from].x - graph.poses[node].x,
                                      graph.poses[edge.from].y - graph.poses[node].y);
      const double variance = 0.5 * (edge.covariance(0, 0) + edge.covariance(1, 1)) +
                              lever * lever * edge.covariance(2, 2);
      for (const auto& [a, b] : {std::pair(edge.from, edge.to), std::pair(edge.to, edge.from)}) {
        variances[b] = std::min(variances[b], variances[a] + variance);
        edges[b] = std::min(edges[b], edges[a] + 1.0);
      }
    }
  }
  return {variances, edges};
}

/// Of nodes some of which are near and some far, some known and some hardly.
TEST(GraphDistance, IsThatOfBruteForce) {
  constexpr double kSigma = 2.0;  // [m]
  Random random(7);
  std::size_t far_and_known = 0;
  std::size_t far_and_unknown = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const auto pick = [&](std::size_t below) {
      return std::min(below - 1,
                      static_cast<std::size_t>(random.uniform() * static_cast<double>(below)));
    };
    const auto any_covariance = [&] {
      return diagonal_covariance(random.uniform(0.01, 0.5), random.uniform(0.01, 0.5),
                                 random.uniform(0.001, 0.02));
    };
    PoseGraph graph;
    AdjacencyList links;
    const std::size_t nodes = 2 + pick(118);
    for (std::size_t i = 0; i < nodes; ++i) {
      graph.poses.push_back({random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0), 0.0});
      if (i > 0) {
        graph.edges.push_back(edge(i - 1, i, any_covariance()));
      }
      if (pick(2) == 0) {
        links.take_new(graph.poses.size(), graph.edges);  // as the edges come
      }
    }
    for (std::size_t loops = pick(4); loops > 0; --loops) {
      const std::size_t from = pick(nodes);
      const std::size_t to = (from + 1 + pick(nodes - 1)) % nodes;
      graph.edges.push_back(edge(from, to, any_covariance(), EdgeKind::kLoop,
                                 pick(2) == 0 ? LoopVerdict::kInlier : LoopVerdict::kOutlier));
    }
    links.take_new(graph.poses.size(), graph.edges);
    const std::size_t node = pick(nodes);
    const PathUncertainty ways(graph, links, node);
    const Ways expected = by_force(graph, node);
    const std::vector<double> variances = ways.variances(all_of(graph));
    const std::vector<bool> is_apart = ways.weakly_connected(all_of(graph), kSigma);
    for (std::size_t i = 0; i < nodes; ++i) {
      ASSERT_NEAR(variances[i], expected.variances[i], 1e-9) << trial << ' ' << i;
      const bool is_far = expected.edges[i] > 40.0;
      const bool is_hardly_known = expected.variances[i] > kSigma * kSigma;
      ASSERT_EQ(is_apart[i], is_far && is_hardly_known) << trial << ' ' << i;
      far_and_known += is_far && !is_hardly_known ? 1 : 0;
      far_and_unknown += is_far && is_hardly_known ? 1 : 0;
    }
  }
  EXPECT_GT(far_and_known, 100U);
  EXPECT_GT(far_and_unknown, 100U);
}

}  // namespace
}  // namespace matchbox_slam
