#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "odometry/local_map_covariance.hpp"

namespace matchbox_slam {
namespace {

const Eigen::Matrix3d kFirst = Eigen::Vector3d(4e-6, 9e-6, 1e-6).asDiagonal();
const Eigen::Matrix3d kMatch = Eigen::Vector3d(1e-6, 2e-6, 3e-7).asDiagonal();
const Eigen::Matrix3d kWide = 1e3 * Eigen::Matrix3d::Identity();
const Pose2 kHere{3.0, -2.0, 0.7};

void expect_near(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  EXPECT_TRUE(a.isApprox(b, 1e-6)) << a << "\n\n" << b;
}

/// Of a pose that is matched there next.
Eigen::Matrix3d covariance_at(LocalMapCovariance errors, const Pose2& pose,
                              const Eigen::Matrix3d& prior, const Eigen::Matrix3d& match) {
  errors.follow(pose, prior, match);
  return errors.covariance();
}

/// One key scan, and a second one matched against it.
LocalMapCovariance two_at(const Pose2& pose) {
  LocalMapCovariance errors(pose, kFirst);
  errors.follow(pose, kWide, kMatch);
  errors.add();
  return errors;
}

Eigen::Matrix3d random_covariance(Random& random, double scale) {
  Eigen::Matrix3d root;
  for (int i = 0; i < 9; ++i) {
    root(i / 3, i % 3) = scale * random.gaussian();
  }
  return root * root.transpose() + 0.1 * scale * scale * Eigen::Matrix3d::Identity();
}

TEST(LocalMapCovariance, AMapOfOneScanHasItsErrorAndTheMatchAddsItsOwn) {
  const LocalMapCovariance errors(kHere, kFirst);
  expect_near(errors.covariance(), kFirst);
  expect_near(covariance_at(errors, kHere, kWide, kMatch), kFirst + kMatch);
  expect_near(covariance_at(errors, kHere, kMatch, kMatch), kFirst + kMatch);
}

TEST(LocalMapCovariance, AHeadingErrorMovesWhatIsFarAway) {
  const Pose2 ahead = Pose2{10.0, 0.0, 0.0} * kHere;
  const Eigen::Matrix3d covariance = covariance_at({kHere, kFirst}, ahead, kWide, kMatch);
  EXPECT_NEAR(covariance(0, 0), 4e-6 + 1e-6, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 9e-6 + 100.0 * 1e-6 + 2e-6, 1e-12);
  EXPECT_NEAR(covariance(1, 2), 10.0 * 1e-6, 1e-12);
}

TEST(LocalMapCovariance, AMapOfTwoScansHasTheirMeanError) {
  const LocalMapCovariance errors =
      two_at(kHere);  // the second one's error is the first one's and its own
  expect_near(errors.covariance(), kFirst + kMatch);
  const Eigen::Matrix3d next = 1e-9 * Eigen::Matrix3d::Identity();
  expect_near(covariance_at(errors, kHere, kWide, next), kFirst + 0.25 * kMatch + next);
}

TEST(LocalMapCovariance, WhereTheMapSaysNothingTheNewestScansErrorStays) {
  const LocalMapCovariance errors = two_at({});
  const Eigen::Matrix3d prior = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  expect_near(covariance_at(errors, {}, prior, prior), kFirst + kMatch + prior);
  // Along x only: there the match is no better than the prior.
  const Eigen::Matrix3d match = Eigen::Vector3d(1e-4, 1e-9, 1e-10).asDiagonal();
  const Eigen::Matrix3d covariance = covariance_at(errors, {}, prior, match);
  EXPECT_NEAR(covariance(0, 0), 4e-6 + 1e-6 + 1e-4, 1e-9);
  EXPECT_NEAR(covariance(1, 1), 9e-6 + 0.25 * 2e-6 + 1e-9, 1e-9);
  EXPECT_NEAR(covariance(2, 2), 1e-6 + 0.25 * 3e-7 + 1e-10, 1e-9);
}

/// Matches that each say a little replace the prediction in the end as one that says all.
TEST(LocalMapCovariance, ManyMatchesReplaceThePredictionTogether) {
  LocalMapCovariance errors = two_at({});
  const Eigen::Matrix3d match = 1e-9 * Eigen::Matrix3d::Identity();
  errors.follow({}, 2.0 * match, match);  // half of it each time
  expect_near(errors.covariance(), kFirst + (0.25 + 0.25 + 0.0625) * kMatch + match);
  for (int i = 0; i < 20; ++i) {
    errors.follow({}, 2.0 * match, match);
  }
  expect_near(errors.covariance(), kFirst + 0.25 * kMatch + match);
}

Eigen::Matrix3d moved_by(double x, double y) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 2) = -y;
  matrix(1, 2) = x;
  return matrix;
}

TEST(LocalMapCovariance, AHeadingErrorOfTheNewestScanMovesWhatIsPredictedFromIt) {
  const LocalMapCovariance errors = two_at({});
  const Eigen::Matrix3d prior = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  const Eigen::Matrix3d moved = moved_by(6.0, 8.0);
  expect_near(covariance_at(errors, {6.0, 8.0, 0.0}, prior, prior),
              moved * (kFirst + kMatch) * moved.transpose() + prior);
}

/// Two key scans 2 m apart, and the base away from both.
TEST(LocalMapCovariance, CountsNearKeyScansMoreAndMovesTheErrorsOfEach) {
  LocalMapCovariance errors({}, kFirst);
  errors.follow({2.0, 0.0, 0.0}, kWide, kMatch);
  errors.add();
  // first = a, second = moved_by(2, 0) a + b with a of kFirst and b of kMatch; at (1.5, 1).
  const double near = std::exp(-0.5 * (0.25 + 1.0) / 1.44);
  const double far = std::exp(-0.5 * (2.25 + 1.0) / 1.44);
  const double share = near / (near + far);
  const Eigen::Matrix3d of_first = moved_by(1.5, 1.0);
  const Eigen::Matrix3d of_second = share * moved_by(-0.5, 1.0);
  const Eigen::Matrix3d next = 1e-9 * Eigen::Matrix3d::Identity();
  expect_near(
      covariance_at(errors, {1.5, 1.0, 0.0}, kWide, next),
      of_first * kFirst * of_first.transpose() + of_second * kMatch * of_second.transpose() + next);
}

TEST(LocalMapCovariance, AMatchLeavesOfThePriorWhatTheCovariancesSay) {
  Eigen::Matrix3d prior;
  prior << 4e-9, 1e-9, 0.0, 1e-9, 2e-9, 5e-10, 0.0, 5e-10, 1e-9;
  const Eigen::Matrix3d measured = Eigen::Vector3d(1e-9, 5e-9, 2e-9).asDiagonal();
  const Eigen::Matrix3d match = (prior.inverse() + measured.inverse()).inverse();
  // The mean error is a + b / 2, the newest one's a + b.
  const Eigen::Matrix3d of_b = 0.5 * (Eigen::Matrix3d::Identity() + match * prior.inverse());
  expect_near(covariance_at(two_at({}), {}, prior, match),
              kFirst + of_b * kMatch * of_b.transpose() + match);
}

/// A pose error that a partial match leaves is moved on with the base.
TEST(LocalMapCovariance, WhatMatchesLeaveIsMovedOn) {
  const LocalMapCovariance made = two_at({});
  Eigen::Matrix3d left;  // by each match: of the prior's error, in x and in heading
  left << 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25;
  const Eigen::Matrix3d prior = Eigen::Vector3d(2e-4, 2e-4, 2e-4).asDiagonal();
  const Eigen::Matrix3d match = Eigen::Vector3d(1e-4, 0.0, 0.5e-4).asDiagonal();
  LocalMapCovariance errors = made;
  errors.follow({1.0, 3.0, 0.0}, prior, match);
  errors.follow({2.0, -1.0, 0.0}, prior, match);
  // In the fixed frame's terms about the key scans' place, where both key scans are.
  const auto about_keys = [&](double x, double y) -> Eigen::Matrix3d {
    return moved_by(-x, -y) * left * moved_by(x, y);
  };
  const Eigen::Matrix3d by_prediction = about_keys(2.0, -1.0) * about_keys(1.0, 3.0);
  // The mean error is a + b / 2, the newest one's a + b.
  const Eigen::Matrix3d of_b = 0.5 * Eigen::Matrix3d::Identity() + 0.5 * by_prediction;
  const Eigen::Matrix3d moved = moved_by(2.0, -1.0);
  expect_near(errors.covariance(),
              moved * (kFirst + of_b * kMatch * of_b.transpose()) * moved.transpose() + match);
}

TEST(LocalMapCovariance, ScansFarAwayDoNotCount) {
  LocalMapCovariance errors({}, kFirst);
  const Pose2 far{100.0, 0.0, 0.0};
  errors.follow(far, kWide, kMatch);
  errors.add();
  LocalMapCovariance newest = errors;
  newest.keep_newest(1);
  const Eigen::Matrix3d next = 1e-9 * Eigen::Matrix3d::Identity();
  expect_near(covariance_at(errors, far, kWide, next), covariance_at(newest, far, kWide, next));
  // Nor does it matter how far everything is.
  EXPECT_TRUE(covariance_at(errors, {1e6, 1e6, 0.0}, kWide, next).allFinite());
}

TEST(LocalMapCovariance, KeepsTheNewestButOneAtLeastAndAtMostAll) {
  LocalMapCovariance errors = two_at(kHere);
  errors.keep_newest(5);
  EXPECT_EQ(errors.size(), 2U);
  expect_near(covariance_at(errors, kHere, kWide, kMatch), kFirst + 1.25 * kMatch);
  LocalMapCovariance one = errors;
  one.keep_newest(1);
  EXPECT_EQ(one.size(), 1U);
  EXPECT_EQ(one.bytes(), 9 * sizeof(double));
  expect_near(covariance_at(one, kHere, kWide, kMatch), kFirst + 2.0 * kMatch);
  errors.keep_newest(0);
  expect_near(covariance_at(errors, kHere, kWide, kMatch), kFirst + 2.0 * kMatch);
}

/// The fixed frame is a matter of choice.
TEST(LocalMapCovariance, AnotherFixedFrameGivesTheSameCovarianceThere) {
  const Pose2 other_from_fixed{-7e4, 2e5, 1.1};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(1.1), -std::sin(1.1), std::sin(1.1), std::cos(1.1);
  const auto in_other = [&](const Eigen::Matrix3d& covariance) -> Eigen::Matrix3d {
    return turn * covariance * turn.transpose();
  };
  Random random(4);
  Pose2 pose = kHere;
  const Eigen::Matrix3d first = random_covariance(random, 1e-3);
  LocalMapCovariance here(pose, first);
  LocalMapCovariance there(other_from_fixed * pose, in_other(first));
  for (int i = 0; i < 120; ++i) {
    pose = pose * Pose2{0.1, 0.02 * random.gaussian(), 0.1 * random.gaussian()};
    const Eigen::Matrix3d match = random_covariance(random, 1e-3);
    const Eigen::Matrix3d prior = match + random_covariance(random, 1e-3);
    here.follow(pose, prior, match);
    there.follow(other_from_fixed * pose, in_other(prior), in_other(match));
    const Eigen::Matrix3d covariance = here.covariance();
    ASSERT_EQ(Eigen::LLT<Eigen::Matrix3d>(covariance).info(), Eigen::Success) << i;
    expect_near(there.covariance(), in_other(covariance));
    if (i % 3 == 0) {
      here.add();
      there.add();
    }
    if (i % 60 == 59) {
      here.keep_newest(10);
      there.keep_newest(10);
    }
  }
}

TEST(LocalMapCovariance, APriorWithoutVarianceIsNoTrouble) {
  const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
  expect_near(covariance_at({kHere, kFirst}, kHere, none, none), kFirst);
}

}  // namespace
}  // namespace matchbox_slam
