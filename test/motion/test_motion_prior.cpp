#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/motion/motion_prior.hpp"

namespace matchbox_slam {
namespace {

double square(double value) { return value * value; }

TEST(MotionFromOdometry, IsTakenInTheBaseFrame) {
  // The odometry's heading is 90 degrees; driving along its y axis is driving ahead.
  const MotionEstimate motion =
      motion_from_odometry({5.0, 2.0, 0.5 * kPi}, {5.0, 3.0, 0.5 * kPi}, 1.0, {});
  EXPECT_NEAR(motion.previous_from_current.x, 1.0, 1e-15);
  EXPECT_NEAR(motion.previous_from_current.y, 0.0, 1e-15);
  EXPECT_NEAR(motion.previous_from_current.theta, 0.0, 1e-15);
}

/// Defect of another implementation: the increment was added to the pose in the map unrotated.
TEST(MotionFromOdometry, MovesAlongTheHeadingInTheMap) {
  const MotionEstimate motion = motion_from_odometry({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1.0, {});
  const Pose2 predicted = Pose2{3.0, 4.0, 0.5 * kPi} * motion.previous_from_current;
  EXPECT_NEAR(predicted.x, 3.0, 1e-15);
  EXPECT_NEAR(predicted.y, 5.0, 1e-15);
  EXPECT_NEAR(predicted.theta, 0.5 * kPi, 1e-15);
}

TEST(MotionFromOdometry, TurnsAcrossTheWrapAreSmall) {
  MotionPriorOptions options;
  const MotionEstimate motion =
      motion_from_odometry({0.0, 0.0, 3.1}, {0.0, 0.0, -3.1}, 1.0, options);
  EXPECT_NEAR(motion.previous_from_current.theta, 2.0 * kPi - 6.2, 1e-14);
  const MotionEstimate same = motion_from_odometry({}, {0.0, 0.0, 2.0 * kPi - 6.2}, 1.0, options);
  EXPECT_TRUE(motion.covariance.isApprox(same.covariance, 1e-9));
}

/// The floor is apart, and everything in the base frame.
TEST(MotionFromOdometry, VarianceGrowsWithWayTurnAndTime) {
  MotionPriorOptions options;
  options.translation_floor = 0.01;
  options.translation_by_way = 0.2;
  options.translation_by_turn = 0.05;
  options.translation_by_time = 0.07;
  options.rotation_floor = 0.02;
  options.rotation_by_way = 0.1;
  options.rotation_by_turn = 0.3;
  options.rotation_by_time = 0.04;
  const MotionEstimate rest = motion_from_odometry({1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}, 3.0, options);
  const double rest_xy = 3.0 * 0.07 * 0.07;
  const Eigen::Vector3d at_rest(rest_xy, rest_xy, 3.0 * 0.04 * 0.04);
  EXPECT_TRUE(rest.covariance.isApprox(Eigen::Matrix3d(at_rest.asDiagonal()), 1e-12));
  const Eigen::Vector3d floor(0.0001, 0.0001, 0.0004);
  EXPECT_TRUE(rest.floor.isApprox(Eigen::Matrix3d(floor.asDiagonal()), 1e-12));

  const MotionEstimate motion = motion_from_odometry({}, {-1.2, 1.6, -0.5}, 3.0, options);
  const double xy = 2.0 * 0.2 * 0.2 + 0.5 * 0.05 * 0.05 + rest_xy;
  const double theta = 2.0 * 0.1 * 0.1 + 0.5 * 0.3 * 0.3 + 3.0 * 0.04 * 0.04;
  EXPECT_NEAR(motion.covariance(2, 2), theta, 1e-12);
  // A heading that is wrong moves what comes after it to the side.
  EXPECT_NEAR(motion.covariance(0, 0), xy + theta * 1.6 * 1.6 / 3.0, 1e-12);
  EXPECT_NEAR(motion.covariance(1, 1), xy + theta * 1.2 * 1.2 / 3.0, 1e-12);
  EXPECT_NEAR(motion.covariance(0, 2), -theta * 1.6 / 2.0, 1e-12);
  EXPECT_NEAR(motion.covariance(1, 2), -theta * 1.2 / 2.0, 1e-12);
}

TEST(MotionAtConstantVelocity, GoesOnAtTheSameSpeed) {
  const MotionEstimate motion = motion_at_constant_velocity({0.2, -0.1, 0.3}, 0.1, 0.05, {});
  EXPECT_NEAR(motion.previous_from_current.x, 0.1, 1e-15);
  EXPECT_NEAR(motion.previous_from_current.y, -0.05, 1e-15);
  EXPECT_NEAR(motion.previous_from_current.theta, 0.15, 1e-15);
}

TEST(MotionAtConstantVelocity, WithoutALastMotionTheBaseRests) {
  const MotionEstimate motion = motion_at_constant_velocity({}, 0.0, 0.1, {});
  EXPECT_EQ(motion.previous_from_current, Pose2{});
  EXPECT_TRUE(motion.covariance.allFinite());
  EXPECT_GT(motion.covariance(0, 0), 0.0);
}

TEST(MotionAtConstantVelocity, TheVelocityHasChangedSince) {
  MotionPriorOptions options;
  options.translation_floor = 0.01;
  options.velocity_change = 2.0;
  options.rotation_floor = 0.02;
  options.turn_rate_change = 3.0;
  const MotionEstimate motion = motion_at_constant_velocity({0.1, 0.0, 0.0}, 0.1, 0.5, options);
  EXPECT_NEAR(motion.covariance(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(motion.covariance(2, 2), 1.5 * 1.5, 1e-12);
  // Half a metre on, at a turn rate that is 3 rad/s off: half of the turn to the side.
  EXPECT_NEAR(motion.covariance(1, 1), 1.0 + 0.25 * 0.25 * 1.5 * 1.5, 1e-12);
  EXPECT_NEAR(motion.floor(0, 0), 0.0001, 1e-12);
  EXPECT_NEAR(motion.floor(2, 2), 0.0004, 1e-12);
}

TEST(WithMeasuredTurn, OnlyTheWayIsGuessed) {
  const MotionEstimate motion =
      with_measured_turn(motion_at_constant_velocity({0.1, 0.0, 0.2}, 0.1, 0.1, {}), 0.3, 0.005);
  EXPECT_EQ(motion.previous_from_current, (Pose2{0.1, 0.0, 0.3}));
  EXPECT_EQ(motion.covariance(2, 2), 0.0);
  EXPECT_NEAR(motion.covariance(1, 1), 0.01 * square(MotionPriorOptions{}.velocity_change), 1e-12);
  EXPECT_NEAR(motion.floor(2, 2), 0.005 * 0.005, 1e-15);
}

TEST(LeftByMatch, TellsWhatOfThePriorIsInTheAnswer) {
  const Eigen::Matrix3d prior = Eigen::Vector3d(0.04, 0.01, 0.02).asDiagonal();
  const Eigen::Matrix3d match = Eigen::Vector3d(0.01, 0.01, 0.0).asDiagonal();
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.25, 1.0, 0.0).asDiagonal();
  EXPECT_TRUE(left_by_match(prior, match).isApprox(expected, 1e-12));
  EXPECT_TRUE(left_by_match(prior, 3.0 * prior).isIdentity(1e-12)) << "never more than all";
  EXPECT_TRUE(left_by_match(Eigen::Matrix3d::Zero(), match).isIdentity());
}

TEST(WithoutOvershoot, TakesBackWhatAWrongPredictionDidToTheScan) {
  const Pose2 predicted{1.0, 2.0, 0.5};
  const Pose2 truth{1.3, 1.4, 0.2};
  EXPECT_EQ(without_overshoot(predicted, truth, 0.0), truth) << "all beams at once";
  // The mean beam is at half the sweep, which takes the whole time from scan to scan.
  const Pose2 matched{truth.x + 0.15, truth.y - 0.3, truth.theta - 0.15};
  const Pose2 found = without_overshoot(predicted, matched, 1.0);
  EXPECT_NEAR(found.x, truth.x, 1e-12);
  EXPECT_NEAR(found.y, truth.y, 1e-12);
  EXPECT_NEAR(found.theta, truth.theta, 1e-12);
  // Two lasers that take turns.
  const Pose2 by_two{truth.x + 0.3, truth.y - 0.6, truth.theta - 0.3};
  EXPECT_NEAR(without_overshoot(predicted, by_two, 2.0).y, truth.y, 1e-12);
}

}  // namespace
}  // namespace matchbox_slam
