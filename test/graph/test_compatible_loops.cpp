#include <gtest/gtest.h>

#include "graph/compatible_loops.hpp"

namespace matchbox_slam {
namespace {

using Places = std::vector<std::size_t>;

constexpr double kMostChiSquare = 16.0;

/// Loops over the same stretch of odometry that is known to `odometry`, each with its own variance;
/// they differ from odometry by so much in x.
LoopErrors errors_in_x(double odometry, const std::vector<double>& errors,
                       const std::vector<double>& variances) {
  const auto size = 3 * static_cast<Eigen::Index>(errors.size());
  LoopErrors result{Places(errors.size()), Eigen::VectorXd::Zero(size),
                    Eigen::MatrixXd::Identity(size, size)};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    result.error[3 * static_cast<Eigen::Index>(i)] = errors[i];
    for (std::size_t j = 0; j < errors.size(); ++j) {
      result.covariance(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) =
          odometry + (i == j ? variances[i] : 0.0);
    }
  }
  return result;
}

TEST(CompatibleLoops, AreWeighedByWhatOdometryKnows) {
  EXPECT_EQ(compatible_loops(errors_in_x(1.0, {3.9}, {0.01}), kMostChiSquare), Places{0});
  EXPECT_EQ(compatible_loops(errors_in_x(1.0, {4.1}, {0.01}), kMostChiSquare), Places{});
}

TEST(CompatibleLoops, AreWeighedByThoseTakenBefore) {
  EXPECT_EQ(compatible_loops(errors_in_x(1.0, {3.0, 3.1, 1.0}, {0.01, 0.02, 0.03}), kMostChiSquare),
            (Places{0, 1}));
  EXPECT_EQ(
      compatible_loops(errors_in_x(1.0, {3.0, 3.1, 1.0}, {0.01, 0.02, 0.03}), kMostChiSquare, 2),
      (Places{2}));
}

TEST(CompatibleLoops, TheMostCertainIsAskedFirst) {
  EXPECT_EQ(compatible_loops(errors_in_x(1.0, {3.0, -3.0}, {0.02, 0.01}), kMostChiSquare),
            Places{1});
}

/// Where only a loop says where the rest of the graph is, the optimiser's last digits are no
/// contradiction.
TEST(WorstLoop, IsNoneThatNothingContradicts) {
  PoseGraph graph;
  graph.poses = {{}, {1.000001, 0.0, 0.0}};
  graph.edges = {{0, 1, {}, 1e8 * Eigen::Matrix3d::Identity()},
                 {0,
                  1,
                  {1.0, 0.0, 0.0},
                  1e-4 * Eigen::Matrix3d::Identity(),
                  EdgeKind::kLoop,
                  LoopVerdict::kInlier}};
  EXPECT_EQ(worst_loop(graph, kMostChiSquare), std::nullopt);
}

/// Of three that tell how far a step was the one that differs, by as much as without it.
TEST(WorstLoop, IsTheOneThatDiffersMostFromTheOthers) {
  PoseGraph graph;
  graph.poses = {{}, {1.05, 0.0, 0.0}};
  const Eigen::Matrix3d covariance = 1e-4 * Eigen::Matrix3d::Identity();
  graph.edges = {{0, 1, {1.0, 0.0, 0.0}, covariance}};
  for (const double x : {1.0, 1.0, 1.2}) {
    graph.edges.push_back({0, 1, {x, 0.0, 0.0}, covariance, EdgeKind::kLoop, LoopVerdict::kInlier});
  }
  const double chi_square_without = 0.2 * 0.2 / (1e-4 + 1e-4 / 3.0);
  EXPECT_EQ(worst_loop(graph, 0.999 * chi_square_without), std::optional<std::size_t>(3));
  EXPECT_EQ(worst_loop(graph, 1.001 * chi_square_without), std::nullopt);
}

}  // namespace
}  // namespace matchbox_slam
