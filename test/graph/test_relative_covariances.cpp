#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>
#include <stdexcept>

#include "graph/edge_error.hpp"
#include "graph/random_graphs.hpp"
#include "matchbox_slam/graph/optimise.hpp"
#include "matchbox_slam/graph/relative_covariances.hpp"

namespace matchbox_slam {
namespace {

RandomGraph optimised_graph() {
  RandomGraphOptions options;
  options.nodes = 60;
  options.loops = 8;
  RandomGraph made = random_graph(11, options);
  for (PoseEdge& edge : made.graph.edges) {
    edge.covariance(0, 1) = edge.covariance(1, 0) = 0.5 * edge.covariance(0, 0);
  }
  made.graph = optimise(made.graph).graph;
  return made;
}

std::vector<std::size_t> all_nodes(const PoseGraph& graph) {
  std::vector<std::size_t> nodes(graph.poses.size());
  std::iota(nodes.begin(), nodes.end(), std::size_t{0});
  return nodes;
}

/// Through the dense inverse with the first node fixed, and the derivatives of the pose as seen
/// from the reference.
TEST(RelativeCovariances, AreThoseOfTheDenseInverse) {
  const PoseGraph graph = optimised_graph().graph;
  const auto size = 3 * static_cast<Eigen::Index>(graph.poses.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  const auto derivatives = [&](const PoseEdge& edge) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, size);
    const EdgeError error = edge_error(graph, edge);
    rows.middleCols<3>(3 * static_cast<Eigen::Index>(edge.from)) = error.by_from;
    rows.middleCols<3>(3 * static_cast<Eigen::Index>(edge.to)) = error.by_to;
    return rows;
  };
  for (const PoseEdge& edge : graph.edges) {
    ASSERT_TRUE(is_used(edge));
    const Eigen::MatrixXd rows = derivatives(edge);
    information += rows.transpose() * edge.covariance.inverse() * rows;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  covariance.bottomRightCorner(size - 3, size - 3) =
      information.bottomRightCorner(size - 3, size - 3).inverse();
  for (const std::size_t reference : {std::size_t{0}, std::size_t{23}, graph.poses.size() - 1}) {
    const auto result = relative_covariances(graph, reference, all_nodes(graph));
    for (std::size_t node = 0; node < graph.poses.size(); ++node) {
      PoseEdge between;
      between.from = reference;
      between.to = node;
      const Eigen::MatrixXd rows = derivatives(between);
      const Eigen::Matrix3d expected = node == reference
                                           ? Eigen::Matrix3d(Eigen::Matrix3d::Zero())
                                           : Eigen::Matrix3d(rows * covariance * rows.transpose());
      EXPECT_LE((result[node] - expected).norm(), 1e-9 * expected.norm())
          << reference << ' ' << node << '\n'
          << result[node] << "\n\n"
          << expected;
    }
  }
}

/// Of what the same drive would have given again and again.
TEST(RelativeCovariances, AreThoseOfSamples) {
  const RandomGraph made = optimised_graph();
  PoseGraph graph = made.graph;
  graph.poses = made.truth;
  const std::vector<std::size_t> nodes = {5, 30, 59};
  const std::size_t reference = 40;
  const auto expected = relative_covariances(graph, reference, nodes);
  Random random(3);
  constexpr int kSamples = 2000;
  std::vector<Eigen::Matrix3d> sums(nodes.size(), Eigen::Matrix3d::Zero());
  for (int sample = 0; sample < kSamples; ++sample) {
    PoseGraph noisy_graph = graph;
    for (PoseEdge& edge : noisy_graph.edges) {
      edge.from_to =
          noisy(made.truth[edge.from].inverse() * made.truth[edge.to], edge.covariance, random);
    }
    const std::vector<Pose2> poses = optimise(noisy_graph).graph.poses;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Eigen::Vector3d error =
          difference(poses[reference].inverse() * poses[nodes[i]],
                     made.truth[reference].inverse() * made.truth[nodes[i]]);
      sums[i] += error * error.transpose();
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Matrix3d sampled = sums[i] / kSamples;
    // In the expected one's own measure a sample covariance is the identity but for 1 / sqrt(n).
    const Eigen::Matrix3d root = expected[i].llt().matrixL();
    const Eigen::Matrix3d whitened = root.inverse() * sampled * root.inverse().transpose();
    EXPECT_LT((whitened - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.12)
        << nodes[i] << '\n'
        << whitened;
  }
}

TEST(RelativeCovariances, OutliersSayNothing) {
  PoseGraph graph = optimised_graph().graph;
  PoseGraph without = graph;
  without.edges.pop_back();
  graph.edges.back().verdict = LoopVerdict::kOutlier;
  EXPECT_EQ(relative_covariances(graph, 3, {50}), relative_covariances(without, 3, {50}));
}

TEST(RelativeCovariances, OneNodeIsKnownToItself) {
  PoseGraph graph;
  graph.poses = {{1.0, 2.0, 3.0}};
  EXPECT_EQ(relative_covariances(graph, 0, {0}).front(), Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
  EXPECT_THROW((void)relative_covariances(graph, 1, {0}), std::out_of_range);
  EXPECT_THROW((void)relative_covariances(graph, 0, {1}), std::out_of_range);
}

}  // namespace
}  // namespace matchbox_slam
