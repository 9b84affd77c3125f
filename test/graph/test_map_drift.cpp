#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "graph/edge_error.hpp"
#include "graph/map_drift.hpp"
#include "graph/random_graphs.hpp"
#include "matchbox_slam/graph/optimise.hpp"

namespace matchbox_slam {
namespace {

/// A drive whose motion has this share of the variance that it is said to have, all but a
/// thousandth of which is drift; loops are as good as they say.
RandomGraph drifting(std::uint64_t seed, double share, std::size_t nodes = 300,
                     std::size_t loops = 40) {
  RandomGraphOptions options;
  options.nodes = nodes;
  options.loops = loops;
  options.sigma_xy = 0.02 * std::sqrt(share);
  options.sigma_theta = 0.01 * std::sqrt(share);
  RandomGraph made = random_graph(seed, options);
  for (PoseEdge& edge : made.graph.edges) {
    if (edge.kind == EdgeKind::kMotion) {
      edge.drift = edge.covariance.diagonal() / share;
      edge.covariance *= 1.001 / share;
    }
  }
  return made;
}

double rms_error(const std::vector<Pose2>& poses, const std::vector<Pose2>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += (poses[i].translation() - truth[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

PoseGraph with_drift(PoseGraph graph, double share) {
  for (PoseEdge& edge : graph.edges) {
    edge.covariance = covariance_with_drift(edge, share);
  }
  return graph;
}

PoseGraph without_drift(PoseGraph graph) {
  for (PoseEdge& edge : graph.edges) {
    edge.drift.setZero();
  }
  return graph;
}

/// Of the loops' errors, each by what the poses and the loop contribute, through dense matrices.
double dense_log_likelihood(const PoseGraph& graph) {
  const auto size = 3 * static_cast<Eigen::Index>(graph.poses.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd loops(0, size);
  Eigen::VectorXd errors(0);
  Eigen::MatrixXd covariance(0, 0);
  for (const PoseEdge& edge : graph.edges) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, size);
    const EdgeError error = edge_error(graph, edge);
    rows.middleCols<3>(3 * static_cast<Eigen::Index>(edge.from)) = error.by_from;
    rows.middleCols<3>(3 * static_cast<Eigen::Index>(edge.to)) = error.by_to;
    if (edge.kind == EdgeKind::kMotion) {
      information += rows.transpose() * edge.covariance.inverse() * rows;
      gradient -= rows.transpose() * edge.covariance.inverse() * error.error;
      continue;
    }
    const Eigen::Index at = loops.rows();
    loops.conservativeResize(at + 3, Eigen::NoChange);
    loops.bottomRows<3>() = rows;
    errors.conservativeResize(at + 3);
    errors.tail<3>() = error.error;
    covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(at + 3, at + 3));
    covariance.bottomRightCorner<3, 3>() = edge.covariance;
  }
  const Eigen::MatrixXd free = loops.rightCols(size - 3);
  const Eigen::MatrixXd of_poses = information.bottomRightCorner(size - 3, size - 3).inverse();
  errors += free * of_poses * gradient.tail(size - 3);
  covariance += free * of_poses * free.transpose();
  const Eigen::LDLT<Eigen::MatrixXd> factor(covariance);
  return -0.5 * (errors.dot(factor.solve(errors)) + factor.vectorD().array().log().sum());
}

TEST(MapDrift, IsTheMostLikelyByTheDenseCovarianceOfTheLoops) {
  for (const double share : {1.0, 0.1, 0.01}) {
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      const PoseGraph graph = optimise(without_drift(drifting(seed, share, 60, 8).graph)).graph;
      PoseGraph best = drifting(seed, share, 60, 8).graph;
      best.poses = graph.poses;
      for (PoseEdge& edge : best.edges) {
        edge.verdict = LoopVerdict::kInlier;
      }
      const auto log_posterior = [&](int halvings) {
        return dense_log_likelihood(with_drift(best, std::pow(0.25, halvings))) -
               halvings * halvings;
      };
      int most = 0;
      for (int halvings = 1; halvings <= 6; ++halvings) {
        most = log_posterior(halvings) > log_posterior(most) ? halvings : most;
      }
      EXPECT_EQ(learn_drift(best), std::pow(0.25, most)) << share << " " << seed;
    }
  }
}

TEST(MapDrift, IsAsItIsAssumedWhereNoLoopTells) {
  PoseGraph graph = drifting(1, 0.01).graph;
  EXPECT_EQ(learn_drift(graph), 1.0) << "none is an inlier";
  graph = optimise(graph).graph;
  EXPECT_LT(learn_drift(graph), 1.0);
  EXPECT_EQ(learn_drift(without_drift(graph)), 1.0);
}

TEST(MapDrift, IsFoundToADoubling) {
  for (const double share : {1.0, 1.0 / 16.0, 1.0 / 256.0}) {
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
      const double learned = learn_drift(optimise(drifting(seed, share).graph).graph);
      EXPECT_LE(learned, std::min(1.0, 4.0 * share)) << seed;
      EXPECT_GE(learned, share == 1.0 ? 1.0 : 0.25 * share) << seed;
    }
  }
}

/// Three laps of 200 m, with loops to the lap before at every corner. Of one step in each lap
/// hardly anything is known along it, as in a corridor that is plain.
RandomGraph laps_with_a_corridor(std::uint64_t seed) {
  constexpr std::size_t kLap = 200;
  constexpr double kShare = 1.0 / 4096.0;
  const Eigen::Vector3d assumed(4e-4, 4e-4, 1e-4);
  const Eigen::Matrix3d drift = (kShare * assumed).asDiagonal();
  Random random(seed);
  RandomGraph made;
  made.truth = {Pose2{}};
  made.graph.poses = {Pose2{}};
  for (std::size_t i = 1; i < 3 * kLap; ++i) {
    const Pose2 step{1.0, 0.0, i % 50 == 0 ? kPi / 2.0 : 0.0};
    made.truth.push_back(made.truth.back() * step);
    PoseEdge edge{i - 1, i, noisy(step, drift, random), 1.001 * assumed.asDiagonal()};
    edge.drift = assumed;
    if (i % kLap == 25) {
      edge.from_to.x += 0.3 * random.gaussian();
      edge.covariance(0, 0) += 0.09;
    }
    made.graph.poses.push_back(made.graph.poses.back() * edge.from_to);
    made.graph.edges.push_back(edge);
  }
  const Eigen::Matrix3d found = Eigen::Vector3d(1e-6, 1e-6, 1e-8).asDiagonal();
  for (std::size_t i = kLap; i < 3 * kLap; i += 50) {
    const Pose2 there = made.truth[i - kLap].inverse() * made.truth[i];
    made.graph.edges.push_back({i - kLap, i, noisy(there, found, random), found, EdgeKind::kLoop});
  }
  return made;
}

TEST(MapDrift, WhereThereIsLittleCorridorsGiveWayAndAreNotBent) {
  double by_assumed = 0.0;
  double by_learned = 0.0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    const RandomGraph made = laps_with_a_corridor(seed);
    by_assumed += rms_error(optimise(without_drift(made.graph)).graph.poses, made.truth) / 8.0;
    by_learned += rms_error(optimise(made.graph).graph.poses, made.truth) / 8.0;
  }
  EXPECT_LT(by_learned, 0.45 * by_assumed) << by_learned << " " << by_assumed;
}

/// As by a drift that has come after all that tells how much of it there is.
TEST(MapDrift, ALoopIsDecidedUponWithAllThatIsAssumed) {
  RandomGraph made = laps_with_a_corridor(1);
  const Pose2 turned{0.0, 0.0, 0.02};  // 0.0002 a root metre would be 0.003
  made.graph.edges.push_back({399, 599, made.truth[399].inverse() * made.truth[599] * turned,
                              Eigen::Vector3d(1e-6, 1e-6, 1e-8).asDiagonal(), EdgeKind::kLoop});
  const OptimisedGraph best = optimise(made.graph);
  EXPECT_EQ(best.graph.edges.back().verdict, LoopVerdict::kInlier);
  const PoseGraph stiff = without_drift(with_drift(made.graph, 1.0 / 4096.0));
  EXPECT_EQ(optimise(stiff).graph.edges.back().verdict, LoopVerdict::kOutlier);
  for (std::size_t i = 0; i < made.graph.edges.size(); ++i) {
    EXPECT_EQ(best.graph.edges[i].covariance, made.graph.edges[i].covariance) << i;
  }
  EXPECT_EQ(optimise(made.graph).graph.poses, best.graph.poses) << "the same bits";
}

TEST(MapDrift, OfACovarianceAShareIsLeft) {
  PoseGraph graph;
  graph.poses.resize(2);
  graph.edges = {{0, 1, {}, Eigen::Vector3d(3.0, 4.0, 5.0).asDiagonal()}};
  graph.edges[0].drift = {2.0, 2.0, 4.0};
  const Eigen::Matrix3d left = with_drift(graph, 0.25).edges[0].covariance;
  EXPECT_EQ(left.diagonal(), Eigen::Vector3d(1.5, 2.5, 2.0));
  EXPECT_EQ(with_drift(graph, 1.0).edges[0].covariance, graph.edges[0].covariance);
}

}  // namespace
}  // namespace matchbox_slam
