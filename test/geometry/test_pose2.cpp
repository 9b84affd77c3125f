#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

/// Poses where mistakes show: none, quarter turns, both sides of the wrap, far away, tiny.
std::vector<Pose2> nasty_poses() {
  return {{},
          {1.0, -2.0, 0.0},
          {0.0, 0.0, 0.5 * kPi},
          {3.0, 1.0, -kPi},
          {-1.0, 0.5, std::nextafter(kPi, 0.0)},
          {1e5, -1e5, 2.0},
          {1e-9, -1e-9, -1e-9},
          {-7.0, 4.0, -2.5}};
}

void expect_same(const Pose2& a, const Pose2& b, double scale) {
  const double tolerance = 1e-14 * (1.0 + scale);
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(wrap_angle(a.theta - b.theta), 0.0, 1e-14);
}

double size_of(const Pose2& pose) { return std::abs(pose.x) + std::abs(pose.y); }

void expect_wrapped(const Pose2& pose) {
  EXPECT_GE(pose.theta, -kPi);
  EXPECT_LT(pose.theta, kPi);
}

TEST(Pose2, QuarterTurnTakesXToY) {
  const Pose2 map_from_odom{0.0, 0.0, 0.5 * kPi};
  const Pose2 moved = map_from_odom * Pose2{1.0, 0.0, 0.25};
  EXPECT_NEAR(moved.x, 0.0, 1e-15);
  EXPECT_NEAR(moved.y, 1.0, 1e-15);
  EXPECT_NEAR(moved.theta, 0.5 * kPi + 0.25, 1e-15);
  const Eigen::Vector2d point = Pose2{2.0, 3.0, 0.5 * kPi} * Eigen::Vector2d(1.0, 0.0);
  EXPECT_NEAR(point.x(), 2.0, 1e-15);
  EXPECT_NEAR(point.y(), 4.0, 1e-15);
}

TEST(Pose2, IsAGroup) {
  for (const Pose2& a : nasty_poses()) {
    EXPECT_EQ(a * Pose2{}, a);
    expect_same(Pose2{} * a, a, size_of(a));
    expect_same(a * a.inverse(), Pose2{}, size_of(a));
    expect_same(a.inverse() * a, Pose2{}, size_of(a));
    expect_same(a.inverse().inverse(), a, size_of(a));
    expect_wrapped(a.inverse());
    for (const Pose2& b : nasty_poses()) {
      expect_wrapped(a * b);
      expect_same((a * b).inverse(), b.inverse() * a.inverse(), size_of(a) + size_of(b));
      for (const Pose2& c : nasty_poses()) {
        expect_same((a * b) * c, a * (b * c), size_of(a) + size_of(b) + size_of(c));
      }
    }
  }
}

TEST(Pose2, ActsOnPointsAsItComposes) {
  const Eigen::Vector2d point(0.3, -1.7);
  for (const Pose2& a : nasty_poses()) {
    for (const Pose2& b : nasty_poses()) {
      const Eigen::Vector2d at_once = (a * b) * point;
      const Eigen::Vector2d one_by_one = a * (b * point);
      EXPECT_LT((at_once - one_by_one).norm(), 1e-14 * (3.0 + size_of(a) + size_of(b)));
    }
    EXPECT_LT((a * Eigen::Vector2d::Zero() - a.translation()).norm(), 1e-15);
  }
}

TEST(Transform2, YieldsTheSameBitsAsThePose) {
  const Pose2 pose{1.3, -0.7, 2.1};
  const Eigen::Vector2d point(0.9, 4.2);
  EXPECT_EQ(Transform2(pose) * point, pose * point);
  EXPECT_EQ(Transform2(pose).turned(point), (Pose2{0.0, 0.0, pose.theta} * point));
}

TEST(Pose2, AngleWrapsOnCompositionAndInversion) {
  EXPECT_NEAR((Pose2{0.0, 0.0, 3.0} * Pose2{0.0, 0.0, 3.0}).theta, 6.0 - 2.0 * kPi, 1e-15);
  EXPECT_EQ((Pose2{0.0, 0.0, -kPi}).inverse().theta, -kPi);
}

TEST(Pose2, KnowsWhetherItIsFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE((Pose2{1.0, 2.0, 3.0}).is_finite());
  EXPECT_FALSE((Pose2{kNan, 0.0, 0.0}).is_finite());
  EXPECT_FALSE((Pose2{0.0, std::numeric_limits<double>::infinity(), 0.0}).is_finite());
  EXPECT_FALSE((Pose2{0.0, 0.0, kNan}).is_finite());
  EXPECT_NE((Pose2{kNan, 0.0, 0.0}), (Pose2{kNan, 0.0, 0.0}));
}

TEST(Interpolate, MeetsItsEndsAndTheMiddle) {
  const Pose2 a{1.0, 2.0, 0.2};
  const Pose2 b{3.0, -2.0, 1.0};
  EXPECT_EQ(interpolate(a, b, 0.0), a);
  expect_same(interpolate(a, b, 1.0), b, 5.0);
  expect_same(interpolate(a, b, 0.5), {2.0, 0.0, 0.6}, 5.0);
}

TEST(Interpolate, TurnsAlongTheShorterArc) {
  const Pose2 a{0.0, 0.0, 3.0};
  const Pose2 b{0.0, 0.0, -3.0};
  const double arc = 2.0 * kPi - 6.0;
  for (const double fraction : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const Pose2 between = interpolate(a, b, fraction);
    EXPECT_NEAR(wrap_angle(between.theta - 3.0), fraction * arc, 1e-14);
    expect_wrapped(between);
  }
}

TEST(Interpolate, Extrapolates) {
  expect_same(interpolate({}, {1.0, 0.5, 2.0}, 2.0), {2.0, 1.0, 4.0 - 2.0 * kPi}, 5.0);
  expect_same(interpolate({}, {1.0, 0.5, 2.0}, -1.0), {-1.0, -0.5, -2.0}, 5.0);
}

Pose2 sample(const Pose2& mean, const Eigen::Matrix3d& root, Random& random) {
  const double x = random.gaussian();
  const double y = random.gaussian();
  const Eigen::Vector3d error = root * Eigen::Vector3d(x, y, random.gaussian());
  return {mean.x + error.x(), mean.y + error.y(), wrap_angle(mean.theta + error.z())};
}

TEST(ComposeCovariance, AgreesWithSampledPoses) {
  const Pose2 a_from_b{1.0, -2.0, 3.1};
  const Pose2 b_from_c{2.0, 0.7, 0.3};
  Eigen::Matrix3d root_a;
  root_a << 0.03, 0.0, 0.0, 0.01, 0.02, 0.0, -0.005, 0.004, 0.01;
  Eigen::Matrix3d root_b;
  root_b << 0.02, 0.0, 0.0, -0.01, 0.01, 0.0, 0.01, 0.002, 0.015;
  const Eigen::Matrix3d expected = compose_covariance(a_from_b, root_a * root_a.transpose(),
                                                      b_from_c, root_b * root_b.transpose());
  const Pose2 mean = a_from_b * b_from_c;
  Random random(5);
  constexpr int kSamples = 200000;
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const Pose2 pose = sample(a_from_b, root_a, random) * sample(b_from_c, root_b, random);
    const Eigen::Vector3d error(pose.x - mean.x, pose.y - mean.y,
                                wrap_angle(pose.theta - mean.theta));
    sampled += error * error.transpose() / kSamples;
  }
  // Relative to the deviations of both coordinates; an estimate from n samples is off by about
  // sqrt(2 / n) of that, here 0.3 %, and the first order by about as much.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      EXPECT_NEAR(sampled(i, j) / scale, expected(i, j) / scale, 0.012) << i << ", " << j;
    }
  }
}

TEST(ComposeCovariance, KnownFirstPoseOnlyTurnsTheSecond) {
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1.0, 4.0, 9.0).asDiagonal();
  const Eigen::Matrix3d composed = compose_covariance(
      {5.0, 6.0, 0.5 * kPi}, Eigen::Matrix3d::Zero(), {1.0, 2.0, 3.0}, covariance);
  EXPECT_TRUE(
      composed.isApprox(Eigen::Matrix3d(Eigen::Vector3d(4.0, 1.0, 9.0).asDiagonal()), 1e-14));
}

}  // namespace
}  // namespace matchbox_slam
