#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/slam/key_errors.hpp"

namespace matchbox_slam {
namespace {

const Eigen::Matrix3d kFirst = Eigen::Vector3d(4e-6, 9e-6, 1e-6).asDiagonal();
const Eigen::Matrix3d kMatch = Eigen::Vector3d(1e-6, 2e-6, 3e-7).asDiagonal();
const Eigen::Matrix3d kWide = 1e3 * Eigen::Matrix3d::Identity();
const Pose2 kHere{3.0, -2.0, 0.7};

void expect_near(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  EXPECT_TRUE(a.isApprox(b, 1e-6)) << a << "\n\n" << b;
}

Eigen::Matrix3d random_covariance(Random& random, double scale) {
  Eigen::Matrix3d root;
  for (int i = 0; i < 9; ++i) {
    root(i / 3, i % 3) = scale * random.gaussian();
  }
  return root * root.transpose() + 0.1 * scale * scale * Eigen::Matrix3d::Identity();
}

TEST(KeyErrors, AMapOfOneScanHasItsErrorAndTheMatchAddsItsOwn) {
  const KeyErrors errors(kHere, kFirst);
  expect_near(errors.covariance_of(kHere, kWide, kMatch), kFirst + kMatch);
  expect_near(errors.covariance_of(kHere, kMatch, kMatch), kFirst + kMatch);
}

TEST(KeyErrors, AHeadingErrorMovesWhatIsFarAway) {
  const KeyErrors errors(kHere, kFirst);
  const Pose2 ahead = Pose2{10.0, 0.0, 0.0} * kHere;
  const Eigen::Matrix3d covariance = errors.covariance_of(ahead, kWide, kMatch);
  EXPECT_NEAR(covariance(0, 0), 4e-6 + 1e-6, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 9e-6 + 100.0 * 1e-6 + 2e-6, 1e-12);
  EXPECT_NEAR(covariance(1, 2), 10.0 * 1e-6, 1e-12);
}

TEST(KeyErrors, AMapOfTwoScansHasTheirMeanError) {
  KeyErrors errors(kHere, kFirst);
  errors.add(kHere, kWide, kMatch);  // its error is the first one's and its own
  const Eigen::Matrix3d next = 1e-9 * Eigen::Matrix3d::Identity();
  expect_near(errors.covariance_of(kHere, kWide, next), kFirst + 0.25 * kMatch + next);
}

TEST(KeyErrors, WhereTheMapSaysNothingTheNewestScansErrorStays) {
  KeyErrors errors({}, kFirst);
  errors.add({}, kWide, kMatch);
  const Eigen::Matrix3d prior = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  expect_near(errors.covariance_of({}, prior, prior), kFirst + kMatch + prior);
  // Along x only: there the match is no better than the prior.
  const Eigen::Matrix3d match = Eigen::Vector3d(1e-4, 1e-9, 1e-10).asDiagonal();
  const Eigen::Matrix3d covariance = errors.covariance_of({}, prior, match);
  EXPECT_NEAR(covariance(0, 0), 4e-6 + 1e-6 + 1e-4, 1e-9);
  EXPECT_NEAR(covariance(1, 1), 9e-6 + 0.25 * 2e-6 + 1e-9, 1e-9);
  EXPECT_NEAR(covariance(2, 2), 1e-6 + 0.25 * 3e-7 + 1e-10, 1e-9);
}

TEST(KeyErrors, ScansFarAwayDoNotCount) {
  KeyErrors errors({}, kFirst);
  const Pose2 far{100.0, 0.0, 0.0};
  errors.add(far, kWide, kMatch);
  KeyErrors newest = errors;
  newest.keep_newest(1);
  const Eigen::Matrix3d next = 1e-9 * Eigen::Matrix3d::Identity();
  expect_near(errors.covariance_of(far, kWide, next), newest.covariance_of(far, kWide, next));
  // Nor does it matter how far everything is.
  const Eigen::Matrix3d nowhere = errors.covariance_of({1e6, 1e6, 0.0}, kWide, next);
  EXPECT_TRUE(nowhere.allFinite());
}

TEST(KeyErrors, KeepsTheNewestAndAtMostAllOfThem) {
  KeyErrors errors(kHere, kFirst);
  errors.add(kHere, kWide, kMatch);
  KeyErrors all = errors;
  all.keep_newest(5);
  expect_near(all.covariance_of(kHere, kWide, kMatch), errors.covariance_of(kHere, kWide, kMatch));
  errors.keep_newest(1);
  expect_near(errors.covariance_of(kHere, kWide, kMatch), kFirst + 2.0 * kMatch);
}

/// The fixed frame is a matter of choice.
TEST(KeyErrors, AnotherFixedFrameGivesTheSameCovarianceThere) {
  const Pose2 other_from_fixed{-7.0, 20.0, 1.1};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(1.1), -std::sin(1.1), std::sin(1.1), std::cos(1.1);
  const auto in_other = [&](const Eigen::Matrix3d& covariance) -> Eigen::Matrix3d {
    return turn * covariance * turn.transpose();
  };
  Random random(4);
  Pose2 pose = kHere;
  const Eigen::Matrix3d first = random_covariance(random, 1e-3);
  KeyErrors here(pose, first);
  KeyErrors there(other_from_fixed * pose, in_other(first));
  for (int i = 0; i < 40; ++i) {
    pose = pose * Pose2{0.3, 0.05 * random.gaussian(), 0.3 * random.gaussian()};
    const Eigen::Matrix3d match = random_covariance(random, 1e-3);
    const Eigen::Matrix3d prior = match + random_covariance(random, 1e-3);
    const Eigen::Matrix3d covariance = here.covariance_of(pose, prior, match);
    ASSERT_EQ(Eigen::LLT<Eigen::Matrix3d>(covariance).info(), Eigen::Success) << i;
    expect_near(there.covariance_of(other_from_fixed * pose, in_other(prior), in_other(match)),
                in_other(covariance));
    here.add(pose, prior, match);
    there.add(other_from_fixed * pose, in_other(prior), in_other(match));
    if (i % 20 == 19) {
      here.keep_newest(10);
      there.keep_newest(10);
    }
  }
}

TEST(KeyErrors, APriorWithoutVarianceIsNoTrouble) {
  const KeyErrors errors(kHere, kFirst);
  const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
  expect_near(errors.covariance_of(kHere, none, none), kFirst);
}

}  // namespace
}  // namespace matchbox_slam
