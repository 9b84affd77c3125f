#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/slam/motion_prior.hpp"

namespace matchbox_slam {
namespace {

TEST(MotionFromOdometry, IsTakenInTheBaseFrame) {
  // The odometry's heading is 90 degrees; driving along its y axis is driving ahead.
  const MotionEstimate motion =
      motion_from_odometry({5.0, 2.0, 0.5 * kPi}, {5.0, 3.0, 0.5 * kPi}, {});
  EXPECT_NEAR(motion.previous_from_current.x, 1.0, 1e-15);
  EXPECT_NEAR(motion.previous_from_current.y, 0.0, 1e-15);
  EXPECT_NEAR(motion.previous_from_current.theta, 0.0, 1e-15);
}

/// Defect of another implementation: the increment was added to the pose in the map unrotated.
TEST(MotionFromOdometry, MovesAlongTheHeadingInTheMap) {
  const MotionEstimate motion = motion_from_odometry({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {});
  const Pose2 predicted = Pose2{3.0, 4.0, 0.5 * kPi} * motion.previous_from_current;
  EXPECT_NEAR(predicted.x, 3.0, 1e-15);
  EXPECT_NEAR(predicted.y, 5.0, 1e-15);
  EXPECT_NEAR(predicted.theta, 0.5 * kPi, 1e-15);
}

TEST(MotionFromOdometry, TurnsAcrossTheWrapAreSmall) {
  MotionPriorOptions options;
  const MotionEstimate motion = motion_from_odometry({0.0, 0.0, 3.1}, {0.0, 0.0, -3.1}, options);
  EXPECT_NEAR(motion.previous_from_current.theta, 2.0 * kPi - 6.2, 1e-14);
  const MotionEstimate same = motion_from_odometry({}, {0.0, 0.0, 2.0 * kPi - 6.2}, options);
  EXPECT_TRUE(motion.covariance.isApprox(same.covariance, 1e-9));
}

TEST(MotionFromOdometry, NoiseGrowsWithTheMotion) {
  MotionPriorOptions options;
  options.translation_floor = 0.01;
  options.translation_per_metre = 0.2;
  options.translation_per_radian = 0.05;
  options.rotation_floor = 0.02;
  options.rotation_per_metre = 0.1;
  options.rotation_per_radian = 0.3;
  const MotionEstimate rest = motion_from_odometry({1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}, options);
  EXPECT_NEAR(rest.covariance(0, 0), 0.01 * 0.01, 1e-15);
  EXPECT_NEAR(rest.covariance(2, 2), 0.02 * 0.02, 1e-15);
  const MotionEstimate motion = motion_from_odometry({}, {-1.2, 1.6, -0.5}, options);
  const double sigma_xy = 0.01 + 0.2 * 2.0 + 0.05 * 0.5;
  const double sigma_theta = 0.02 + 0.1 * 2.0 + 0.3 * 0.5;
  const Eigen::Vector3d expected(sigma_xy * sigma_xy, sigma_xy * sigma_xy,
                                 sigma_theta * sigma_theta);
  EXPECT_TRUE(motion.covariance.isApprox(Eigen::Matrix3d(expected.asDiagonal()), 1e-12));
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

TEST(MotionAtConstantVelocity, NoiseGrowsWithTheTime) {
  MotionPriorOptions options;
  options.translation_floor = 0.01;
  options.velocity_change = 2.0;
  options.rotation_floor = 0.02;
  options.turn_rate_change = 3.0;
  const MotionEstimate motion = motion_at_constant_velocity({0.1, 0.0, 0.0}, 0.1, 0.5, options);
  EXPECT_NEAR(motion.covariance(1, 1), 1.01 * 1.01, 1e-12);
  EXPECT_NEAR(motion.covariance(2, 2), 1.52 * 1.52, 1e-12);
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
