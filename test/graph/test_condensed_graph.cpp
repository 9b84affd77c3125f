#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <stdexcept>
#include <vector>

#include "graph/condensed_graph.hpp"
#include "graph/edge_error.hpp"
#include "graph/random_graphs.hpp"
#include "matchbox_slam/graph/optimise.hpp"

namespace matchbox_slam {
namespace {

/// A town's graph whose edges measure what its poses are, so that first order is exact; covariances
/// are skew and differ, and edges of motion drift. Places seen again are sure.
PoseGraph exact_graph(std::size_t nodes, std::size_t crossings, std::uint64_t seed) {
  RandomGraphOptions options;
  options.nodes = nodes;
  options.loops = crossings;
  RandomGraph made = random_graph(seed, options);
  PoseGraph graph = made.graph;
  graph.poses = made.truth;
  Random random(seed);
  for (PoseEdge& edge : graph.edges) {
    edge.from_to = graph.poses[edge.from].inverse() * graph.poses[edge.to];
    const double skew = 1e-4 * random.uniform(-1.0, 1.0);
    edge.covariance = random.uniform(0.3, 3.0) * edge.covariance;
    edge.covariance(0, 1) = edge.covariance(1, 0) = skew;
    if (edge.kind == EdgeKind::kMotion) {
      edge.drift = Eigen::Vector3d(4e-4, 4e-4, 1e-4);
      edge.covariance.diagonal() += edge.drift;
    }
    edge.kind = EdgeKind::kMotion;
  }
  return graph;
}

/// Inverse covariance of all poses but the first, which is fixed.
Eigen::MatrixXd information_of(const PoseGraph& graph, double drift_share) {
  const auto size = 3 * static_cast<Eigen::Index>(graph.poses.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (const PoseEdge& edge : graph.edges) {
    if (!is_used(edge)) {
      continue;
    }
    const EdgeError error = edge_error(graph, edge);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, size);
    rows.middleCols<3>(3 * static_cast<Eigen::Index>(edge.from)) = error.by_from;
    rows.middleCols<3>(3 * static_cast<Eigen::Index>(edge.to)) = error.by_to;
    information += rows.transpose() * covariance_with_drift(edge, drift_share).inverse() * rows;
  }
  return information.bottomRightCorner(size - 3, size - 3);
}

/// Covariance of the poses that stay, but the first, with those that go marginalised out.
Eigen::MatrixXd covariance_of_kept(const PoseGraph& graph, const std::vector<bool>& is_taken,
                                   double drift_share) {
  const Eigen::MatrixXd all = information_of(graph, drift_share).inverse();
  std::vector<Eigen::Index> kept;
  for (std::size_t node = 1; node < is_taken.size(); ++node) {
    for (Eigen::Index i = 0; i < 3 && !is_taken[node]; ++i) {
      kept.push_back(3 * static_cast<Eigen::Index>(node - 1) + i);
    }
  }
  Eigen::MatrixXd covariance(kept.size(), kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (std::size_t j = 0; j < kept.size(); ++j) {
      covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          all(kept[i], kept[j]);
    }
  }
  return covariance;
}

/// Two of three nodes, as they come.
std::vector<bool> two_of_three(std::size_t nodes) {
  std::vector<bool> is_taken(nodes, false);
  for (std::size_t i = 1; i + 1 < nodes; ++i) {
    is_taken[i] = i % 3 != 0;
  }
  return is_taken;
}

/// The least and the largest share that the covariance afterwards is of that before, over all
/// directions of all poses at once.
Eigen::Vector2d shares(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after) {
  const auto values =
      Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(after, before).eigenvalues();
  return {values.minCoeff(), values.maxCoeff()};
}

TEST(CondensedGraph, OfAChainIsTheMarginal) {
  const PoseGraph graph = exact_graph(20, 0, 3);
  const std::vector<bool> is_taken = two_of_three(20);
  const CondensedGraph condensed_graph = condensed(graph, is_taken);
  require_sound(condensed_graph.graph);
  ASSERT_EQ(condensed_graph.graph.poses.size(), 8U);
  EXPECT_EQ(condensed_graph.graph.edges.size(), 7U);
  const Eigen::Vector2d share = shares(covariance_of_kept(graph, is_taken, 1.0),
                                       information_of(condensed_graph.graph, 1.0).inverse());
  EXPECT_NEAR(share.x(), 1.0, 1e-9);
  EXPECT_NEAR(share.y(), 1.0, 1e-9);
}

TEST(CondensedGraph, SaysNothingMoreSurelyThanTheMarginalOfAllPosesTogether) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const PoseGraph graph = exact_graph(60, 25, seed);
    const std::vector<bool> is_taken = two_of_three(60);
    const PoseGraph after = condensed(graph, is_taken).graph;
    require_sound(after);
    EXPECT_LE(after.edges.size(), graph.edges.size() - (graph.poses.size() - after.poses.size()));
    for (const double drift : {1.0, 0.25, 1.0 / 64.0, 1.0 / 4096.0}) {
      const Eigen::Vector2d share = shares(covariance_of_kept(graph, is_taken, drift),
                                           information_of(after, drift).inverse());
      EXPECT_GT(share.x(), 1.0 - 1e-9) << seed << ", share of drift " << drift;
      EXPECT_LT(share.y(), 8.0) << seed << ", share of drift " << drift;
    }
  }
}

TEST(CondensedGraph, MeasuresWhatTheEdgesMeasured) {
  const PoseGraph graph = exact_graph(60, 25, 7);
  const CondensedGraph after = condensed(graph, two_of_three(60));
  for (const PoseEdge& edge : after.graph.edges) {
    EXPECT_LT(edge.from, edge.to);
    EXPECT_LT(edge_error(after.graph, edge).error.norm(), 1e-9);
  }
  for (std::size_t node = 0; node < 60; node += 3) {
    EXPECT_TRUE(after.graph.poses[after.numbers[node]] == graph.poses[node]);
  }
}

TEST(CondensedGraph, HandsLoopsOnWithWhatIsBelievedOfThem) {
  RandomGraphOptions options;
  options.nodes = 90;
  options.loops = 16;
  options.wrong = 0.3;
  const PoseGraph before = optimise(random_graph(4, options).graph).graph;
  const PoseGraph after = condensed(before, two_of_three(90)).graph;
  const auto count = [](const PoseGraph& graph, LoopVerdict verdict) {
    return std::count_if(graph.edges.begin(), graph.edges.end(), [&](const PoseEdge& edge) {
      return edge.kind == EdgeKind::kLoop && edge.verdict == verdict;
    });
  };
  for (const LoopVerdict verdict : {LoopVerdict::kInlier, LoopVerdict::kOutlier}) {
    ASSERT_GT(count(before, verdict), 0);
    EXPECT_EQ(count(after, verdict), count(before, verdict));
  }
  const PoseGraph again = optimise(after).graph;
  EXPECT_EQ(count(again, LoopVerdict::kInlier), count(before, LoopVerdict::kInlier));
  for (std::size_t node = 0; node < again.poses.size(); ++node) {
    // Of 90 steps with an error of 0.03 m each.
    EXPECT_LT(difference(again.poses[node], after.poses[node]).head<2>().norm(), 0.2) << node;
  }
}

/// One place driven through again and again, each time joined to the time before, all but the
/// newest times forgotten.
TEST(CondensedGraph, StaysSparseHoweverLongItGoesOn) {
  constexpr std::size_t kRound = 20;
  PoseGraph graph;
  const auto drive_round = [&graph] {
    for (std::size_t i = 0; i < kRound; ++i) {
      const std::size_t node = graph.poses.size();
      const double angle = 2.0 * kPi * static_cast<double>(i) / kRound;
      graph.poses.push_back({std::cos(angle), std::sin(angle), angle});
      for (const std::size_t earlier : {node - 1, node - kRound - 7}) {
        if (earlier < node) {
          graph.edges.push_back({earlier, node, graph.poses[earlier].inverse() * graph.poses[node],
                                 1e-3 * Eigen::Matrix3d::Identity()});
        }
      }
    }
  };
  drive_round();
  for (int round = 0; round < 40; ++round) {
    drive_round();
    if (graph.poses.size() <= 4 * kRound) {
      continue;
    }
    std::vector<bool> is_taken(graph.poses.size(), false);
    for (std::size_t i = 1; i <= kRound; ++i) {
      is_taken[i + static_cast<std::size_t>(round % 3) * kRound] = true;
    }
    graph = condensed(std::move(graph), is_taken).graph;
    require_sound(graph);
    EXPECT_EQ(graph.poses.size(), 4 * kRound);
    EXPECT_LE(graph.edges.size(), 4 * graph.poses.size());
  }
}

TEST(CondensedGraph, RefusesToTakeOutTheEnds) {
  const PoseGraph graph = exact_graph(6, 0, 1);
  std::vector<bool> is_taken(6, false);
  is_taken.front() = true;
  EXPECT_THROW(static_cast<void>(condensed(graph, is_taken)), std::invalid_argument);
  is_taken.front() = false;
  is_taken.back() = true;
  EXPECT_THROW(static_cast<void>(condensed(graph, is_taken)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(condensed(graph, std::vector<bool>(5, false))),
               std::invalid_argument);
}

}  // namespace
}  // namespace matchbox_slam
