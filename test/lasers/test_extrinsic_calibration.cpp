#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/lasers/extrinsic_calibration.hpp"

namespace matchbox_slam {
namespace {

constexpr double kSigmaXy = 0.004;
constexpr double kSigmaTheta = 0.003;

/// Samples of a laser whose mount and stamps are off by `truth`, of which a share is wrong: found
/// anywhere within 0.2 m and 0.1 rad.
ExtrinsicCalibration estimate_of(const Eigen::Vector4d& truth, int count, double wrong_share,
                                 std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  ExtrinsicCalibration estimate;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d velocity(0.3 + 0.3 * uniform(engine), 0.0, 0.6 * uniform(engine));
    Eigen::Vector3d error = truth.head<3>() + truth(3) * velocity;
    error += Eigen::Vector3d(kSigmaXy * normal(engine), kSigmaXy * normal(engine),
                             kSigmaTheta * normal(engine));
    if (uniform(engine) < 2.0 * wrong_share - 1.0) {
      error << 0.2 * uniform(engine), 0.2 * uniform(engine), 0.1 * uniform(engine);
    }
    estimate.add({error, covariance_of(kSigmaXy, kSigmaTheta), velocity});
  }
  return estimate;
}

TEST(ExtrinsicCalibration, FindsMountAndDelayAmongWrongMatches) {
  for (const double delay : {0.0, -0.08}) {
    const Eigen::Vector4d truth(0.06, -0.08, 0.05, delay);
    const ExtrinsicCalibration estimate = estimate_of(truth, 120, 0.4, 3);
    const Eigen::Vector4d off = estimate.value() - truth;
    EXPECT_LT(off.head<2>().norm(), 0.003) << off.transpose();
    EXPECT_LT(std::abs(off(2)), 0.002) << off.transpose();
    EXPECT_LT(std::abs(off(3)), 0.006) << off.transpose();
    EXPECT_TRUE(estimate.is_sure({0.3, 0.0, 0.5}));
    const Pose2 correction = estimate.correction({0.5, 0.0, 0.0});
    EXPECT_NEAR(correction.x, truth(0) + 0.5 * delay, 0.003);
    EXPECT_NEAR(correction.theta, truth(2), 0.002);
  }
}

/// Its errors are as large as it says; the floor of what matches have in common makes it modest.
TEST(ExtrinsicCalibration, KnowsHowSureItIs) {
  const Eigen::Vector4d truth(0.02, 0.01, -0.03, 0.02);
  double distance = 0.0;
  constexpr int kRuns = 40;
  for (int seed = 0; seed < kRuns; ++seed) {
    const ExtrinsicCalibration estimate =
        estimate_of(truth, 60, 0.1, static_cast<std::uint64_t>(seed));
    const Eigen::Vector4d off = estimate.value() - truth;
    distance += off.dot(estimate.covariance().inverse() * off) / (4.0 * kRuns);
  }
  EXPECT_GT(distance, 0.25);  // 0.43 is measured
  EXPECT_LT(distance, 1.0);
}

TEST(ExtrinsicCalibration, IsUnsureWhileItKnowsLittle) {
  const Eigen::Vector4d truth(0.02, 0.01, -0.03, 0.0);
  EXPECT_FALSE(ExtrinsicCalibration().is_sure(Eigen::Vector3d::Zero()));
  EXPECT_TRUE(ExtrinsicCalibration().value().isZero());
  EXPECT_FALSE(estimate_of(truth, 9, 0.0, 1).is_sure({0.3, 0.0, 0.0}));
  EXPECT_TRUE(estimate_of(truth, 30, 0.0, 1).is_sure({0.3, 0.0, 0.0}));
  // Driving straight on at one speed, a delay and a mount that is ahead look alike, and correct
  // alike, too, at that speed.
  ExtrinsicCalibration ahead;
  for (int i = 0; i < 100; ++i) {
    ahead.add({{0.03, 0.0, 0.0}, covariance_of(kSigmaXy, kSigmaTheta), {0.5, 0.0, 0.0}});
  }
  EXPECT_NEAR(ahead.correction({0.5, 0.0, 0.0}).x, 0.03, 1e-4);
  EXPECT_TRUE(ahead.is_sure({0.5, 0.0, 0.0}));
  EXPECT_FALSE(ahead.is_sure({0.0, 0.0, 0.0}));
}

TEST(ExtrinsicCalibration, TellsThatMatchesContradictEachOther) {
  const ExtrinsicCalibration estimate = estimate_of(Eigen::Vector4d::Zero(), 80, 0.9, 2);
  EXPECT_TRUE(estimate.is_contradictory());
  EXPECT_FALSE(estimate.is_sure({0.3, 0.0, 0.0}));
  EXPECT_FALSE(estimate_of(Eigen::Vector4d::Zero(), 80, 0.2, 2).is_contradictory());
}

TEST(ExtrinsicCalibration, ForgetsOldSamples) {
  ExtrinsicCalibration estimate;
  for (int i = 0; i < 400; ++i) {
    const double x = i < 200 ? 0.0 : 0.05;
    estimate.add({{x, 0.0, 0.0}, covariance_of(kSigmaXy, kSigmaTheta), Eigen::Vector3d::Zero()});
  }
  EXPECT_EQ(estimate.samples().size(), ExtrinsicCalibration::kMostSamples);
  EXPECT_NEAR(estimate.value().x(), 0.05, 1e-3);
}

}  // namespace
}  // namespace matchbox_slam
