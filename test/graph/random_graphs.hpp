#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// A drive whose true poses are known, with loops that are right and loops that are wrong.
struct RandomGraph {
  PoseGraph graph;           ///< poses by odometry
  std::vector<Pose2> truth;  ///< the first one as in the graph
  std::vector<bool> wrong;   ///< of each edge
};

struct RandomGraphOptions {
  std::size_t nodes = 80;
  std::size_t loops = 20;
  double wrong = 0.0;  ///< share of the loops
  double sigma_xy = 0.03;
  double sigma_theta = 0.01;  ///< of motion, a step; loops have them, too
};

inline Pose2 noisy(const Pose2& pose, const Eigen::Matrix3d& covariance, Random& random) {
  const Eigen::Matrix3d root = covariance.llt().matrixL();
  // One after the other: in which order arguments are evaluated differs between processors and
  // compilers.
  const double turned = random.gaussian();
  const double left = random.gaussian();
  const double ahead = random.gaussian();
  return displaced(pose, root * Eigen::Vector3d(ahead, left, turned));
}

/// A drive along the streets of a town, blocks of 6 m, one step a metre. A right loop joins nodes
/// within 2 m. Half of the wrong ones claim that where they are; the others, in runs of several,
/// that a place is the one a block further: as in a row of equal rooms they agree with one another.
inline RandomGraph random_graph(std::uint64_t seed, const RandomGraphOptions& options) {
  Random random(seed);
  RandomGraph result;
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(options.sigma_xy * options.sigma_xy, options.sigma_xy * options.sigma_xy,
                      options.sigma_theta * options.sigma_theta)
          .asDiagonal();
  constexpr int kBlock = 6;
  Pose2 pose{0.0, 0.0, 0.5};
  double street = 0.5;
  for (std::size_t i = 0; i < options.nodes; ++i) {
    result.truth.push_back(pose);
    if (i % kBlock == kBlock - 1) {
      const double turn = random.uniform();
      street += turn < 0.4 ? kPi / 2.0 : turn < 0.6 ? -kPi / 2.0 : 0.0;
    }
    pose = {pose.x + std::cos(street), pose.y + std::sin(street),
            wrap_angle(street + 0.1 * random.gaussian())};
  }
  const auto add = [&](std::size_t from, std::size_t to, const Pose2& from_to, EdgeKind kind,
                       bool wrong) {
    result.graph.edges.push_back({from, to, noisy(from_to, covariance, random), covariance, kind});
    result.wrong.push_back(wrong);
  };
  result.graph.poses.push_back(result.truth.front());
  for (std::size_t i = 1; i < options.nodes; ++i) {
    add(i - 1, i, result.truth[i - 1].inverse() * result.truth[i], EdgeKind::kMotion, false);
    result.graph.poses.push_back(result.graph.poses.back() * result.graph.edges.back().from_to);
  }
  const auto pick = [&] {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(options.nodes));
  };
  const auto from_to = [&](std::size_t from, std::size_t to) {
    return result.truth[from].inverse() * result.truth[to];
  };
  const auto wrong_loops =
      static_cast<std::size_t>(options.wrong * static_cast<double>(options.loops));
  std::size_t loops = 0;
  for (int tries = 0; tries < 100000 && loops < options.loops - wrong_loops; ++tries) {
    const std::size_t from = pick();
    const std::size_t to = pick();
    if (from + 10 < to && from_to(from, to).translation().norm() < 2.0) {
      add(from, to, from_to(from, to), EdgeKind::kLoop, false);
      ++loops;
    }
  }
  // As a share of those that there are.
  auto wrong =
      static_cast<std::size_t>(options.wrong / (1.0 - options.wrong) * static_cast<double>(loops));
  const std::size_t alike = wrong / 2;
  for (; wrong > alike; --wrong) {
    std::size_t from = pick();
    std::size_t to = pick();
    while (from + 10 >= to || from_to(from, to).translation().norm() < 4.0) {
      from = pick();
      to = pick();
    }
    add(from, to, {random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), random.uniform(-0.5, 0.5)},
        EdgeKind::kLoop, true);
  }
  const double direction = 0.5 + std::floor(random.uniform(0.0, 4.0)) * kPi / 2.0;
  const Pose2 shift{kBlock * std::cos(direction), kBlock * std::sin(direction), 0.0};
  for (int tries = 0; tries < 100000 && wrong > 0; ++tries) {
    const std::size_t from = pick();
    const std::size_t to = pick();
    const Pose2 shifted = result.truth[from].inverse() * (shift * result.truth[to]);
    if (from + 10 < to && shifted.translation().norm() < 2.0) {
      add(from, to, shifted, EdgeKind::kLoop, true);
      --wrong;
    }
  }
  return result;
}

}  // namespace matchbox_slam
