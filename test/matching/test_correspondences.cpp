#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/correspondences.hpp"

namespace matchbox_slam {
namespace {

ScanPoint point_at(const Eigen::Vector2d& position, double weight) {
  ScanPoint point;
  point.position = position;
  point.origin = Eigen::Vector2d::Zero();
  point.weight = weight;
  return point;
}

/// Pieces of wall in all directions, some of unknown direction, and points around them. The number
/// of points is no multiple of anything.
struct Clutter {
  LikelihoodField field{0.05, LikelihoodFieldOptions{}};
  std::vector<ScanPoint> points;
  Pose2 map_from_base{0.4, -0.3, 0.5};

  explicit Clutter(std::uint64_t seed) {
    Random random(seed);
    std::vector<SurfaceHit> hits;
    for (int i = 0; i < 61; ++i) {
      const double angle = random.uniform(-kPi, kPi);
      const double x = random.uniform(-3.0, 3.0);
      const Eigen::Vector2d position(x, random.uniform(-3.0, 3.0));
      const bool known = i % 5 != 0;
      hits.push_back({position, known ? Eigen::Vector2d(std::cos(angle), std::sin(angle))
                                      : Eigen::Vector2d(0.0, 0.0)});
      const double off_x = random.uniform(-0.04, 0.08);
      const Eigen::Vector2d seen = position + Eigen::Vector2d(off_x, random.uniform(-0.04, 0.08));
      points.push_back(point_at(map_from_base.inverse() * seen, random.uniform(0.01, 0.1)));
    }
    field.update(hits, {});
  }
};

/// Weighted cost of all residuals under the kernel, but for a constant: the kernel's cost of a
/// residual r is (k^2 / 2) (1 - closeness).
double cost(const Correspondences& pairs, double kernel, const Eigen::Vector3d& step) {
  return -0.5 * kernel * kernel * pairs.total_weight() * pairs.closeness(kernel, step);
}

TEST(Correspondences, GradientIsThatOfTheCost) {
  const Clutter clutter(1);
  const Correspondences pairs(clutter.points, clutter.field, clutter.map_from_base);
  constexpr double kStep = 1e-6;
  for (const double kernel : {0.02, 0.05, 0.3}) {
    const NormalEquations equations = pairs.linearise(kernel);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const double numeric =
          (cost(pairs, kernel, step) - cost(pairs, kernel, -step)) / (2.0 * kStep);
      EXPECT_NEAR(equations.gradient(i), numeric, 1e-7) << "kernel " << kernel << ", " << i;
    }
    EXPECT_GT(equations.gradient.norm(), 1e-3) << "the test shows nothing";
  }
}

TEST(Correspondences, InformationIsTheCurvatureUnderAWideKernel) {
  const Clutter clutter(2);
  const Correspondences pairs(clutter.points, clutter.field, clutter.map_from_base);
  // Under a kernel far wider than all residuals the cost is a parabola, and Gauss-Newton exact.
  constexpr double kKernel = 100.0;
  constexpr double kStep = 0.01;
  const NormalEquations equations = pairs.linearise(kKernel);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d a = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d b = kStep * Eigen::Vector3d::Unit(j);
      const double numeric = (cost(pairs, kKernel, a + b) - cost(pairs, kKernel, a - b) -
                              cost(pairs, kKernel, b - a) + cost(pairs, kKernel, -a - b)) /
                             (4.0 * kStep * kStep);
      EXPECT_NEAR(equations.information(i, j), numeric, 2e-4 * pairs.total_weight());
    }
  }
  EXPECT_EQ(equations.information, Eigen::Matrix3d(equations.information.transpose()));
}

TEST(Correspondences, AStepThatIsTakenGivesTheClosenessForetold) {
  // One wall along y, so that every point keeps its wall whatever the step.
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  std::vector<SurfaceHit> hits;
  std::vector<ScanPoint> points;
  for (double y = -1.0; y <= 1.0; y += 0.01) {
    hits.push_back({{2.0, y}, {1.0, 0.0}});
    points.push_back(point_at({1.97, y}, 0.01));
  }
  field.update(hits, {});
  const Correspondences before(points, field, {});
  EXPECT_NEAR(before.closeness(0.03, Eigen::Vector3d::Zero()), 0.5, 1e-3) << "one kernel off";
  EXPECT_NEAR(before.closeness(0.03, {0.03, 0.0, 0.0}), 1.0, 1e-3);
  EXPECT_NEAR(before.closeness(0.03, {0.03, 0.01, 0.0}), 1.0, 1e-3) << "along the wall";
  const Correspondences after(points, field, {0.01, 0.0, 0.002});
  EXPECT_NEAR(before.closeness(0.03, {0.01, 0.0, 0.002}),
              after.closeness(0.03, Eigen::Vector3d::Zero()), 1e-3);
}

TEST(Correspondences, PointsWithoutAWallCountAsUnexplained) {
  Clutter clutter(3);
  const Correspondences near(clutter.points, clutter.field, clutter.map_from_base);
  const std::size_t count = clutter.points.size();
  for (std::size_t i = 0; i < count; ++i) {
    clutter.points.push_back(clutter.points[i]);
    clutter.points.back().position += Eigen::Vector2d(100.0, 0.0);
  }
  const Correspondences half(clutter.points, clutter.field, clutter.map_from_base);
  EXPECT_NEAR(half.total_weight(), 2.0 * near.total_weight(), 1e-12);
  EXPECT_NEAR(half.closeness(0.05, Eigen::Vector3d::Zero()),
              0.5 * near.closeness(0.05, Eigen::Vector3d::Zero()), 1e-12);
  EXPECT_TRUE(half.linearise(0.05).information.isApprox(near.linearise(0.05).information, 1e-12));
}

TEST(Correspondences, NothingSaysNothing) {
  const Clutter clutter(4);
  const LikelihoodField no_map(0.05, LikelihoodFieldOptions{});
  for (const Correspondences& pairs :
       {Correspondences({}, clutter.field, {}), Correspondences(clutter.points, no_map, {})}) {
    EXPECT_EQ(pairs.closeness(0.05, Eigen::Vector3d::Zero()), 0.0);
    EXPECT_TRUE(pairs.linearise(0.05).information.isZero(0.0));
    EXPECT_TRUE(pairs.linearise(0.05).gradient.isZero(0.0));
  }
}

}  // namespace
}  // namespace matchbox_slam
