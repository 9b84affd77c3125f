#include <gtest/gtest.h>

#include "graph/edge_error.hpp"
#include "graph/random_graphs.hpp"

namespace matchbox_slam {
namespace {

TEST(EdgeError, DerivativesAreThoseOfDifferences) {
  Random random(1);
  const auto pose = [&] {
    return Pose2{random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), random.uniform(-kPi, kPi)};
  };
  for (int i = 0; i < 100; ++i) {
    PoseEdge edge;
    edge.from_to = pose();
    const Pose2 from = pose();
    const Pose2 to = displaced(from * edge.from_to, {0.3, -0.2, random.uniform(-1.0, 1.0)});
    const EdgeError error = edge_error(edge, from, to);
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d by_from = edge_error(edge, displaced(from, step), to).error -
                                      edge_error(edge, displaced(from, -step), to).error;
      const Eigen::Vector3d by_to = edge_error(edge, from, displaced(to, step)).error -
                                    edge_error(edge, from, displaced(to, -step)).error;
      EXPECT_TRUE(error.by_from.col(k).isApprox(by_from / (2.0 * kStep), 1e-7));
      EXPECT_TRUE(error.by_to.col(k).isApprox(by_to / (2.0 * kStep), 1e-7));
    }
  }
}

TEST(EdgeError, HeadingsDifferByTheShorterArc) {
  PoseEdge edge;
  edge.from_to.theta = kPi - 0.1;
  EXPECT_NEAR(edge_error(edge, {0, 0, 2.0}, {0, 0, wrap_angle(2.0 + kPi + 0.1)}).error.z(), 0.2,
              1e-12);
}

TEST(EdgeError, TheRootIsOfTheInverseCovariance) {
  PoseEdge edge;
  edge.covariance << 4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0;
  const Eigen::Matrix3d root = information_root(edge.covariance);
  EXPECT_TRUE((root.transpose() * root * edge.covariance).isIdentity(1e-12));
}

}  // namespace
}  // namespace matchbox_slam
