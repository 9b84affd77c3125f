#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/motion/odometry_noise_scale.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLeast = 0.2;
const Pose2 kStep{0.1, 0.0, 0.0};

Eigen::Matrix3d diagonal_covariance(double x, double y, double theta) {
  return Eigen::Vector3d(x, y, theta).asDiagonal();
}

/// What the options say of a step: 3 cm and 0.02 rad.
const Eigen::Matrix3d kPrior = diagonal_covariance(9e-4, 9e-4, 4e-4);

/// After steps whose errors are this share of what the options say, each matched well.
OdometryNoiseScale after(int steps, double share, OdometryNoiseScale scale, std::uint64_t seed,
                         const Pose2& step = kStep) {
  Random random(seed);
  for (int i = 0; i < steps; ++i) {
    const Pose2 off{share * 0.03 * random.gaussian(), share * 0.03 * random.gaussian(),
                    share * 0.02 * random.gaussian()};
    const double way = scale.translation * scale.translation;
    const double turn = scale.rotation * scale.rotation;
    const Eigen::Matrix3d prior = diagonal_covariance(9e-4 * way, 9e-4 * way, 4e-4 * turn);
    scale = updated_noise_scale(scale, step, {}, prior, off, 0.01 * prior, kLeast);
  }
  return scale;
}

TEST(OdometryNoiseScale, FollowsTheErrorsOfOdometry) {
  double translation = 0.0;
  double rotation = 0.0;
  constexpr int kSeeds = 40;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const OdometryNoiseScale good = after(200, 0.4, {}, static_cast<std::uint64_t>(seed));
    translation += good.translation / kSeeds;
    rotation += good.rotation / kSeeds;
  }
  EXPECT_NEAR(translation, 0.4, 0.04);  // 0.39
  EXPECT_NEAR(rotation, 0.4, 0.04);     // 0.39
  const OdometryNoiseScale bad = after(60, 1.0, {0.2, 0.2}, 3);
  EXPECT_GT(bad.translation, 0.7);
  EXPECT_GT(bad.rotation, 0.7);
}

TEST(OdometryNoiseScale, StaysBetweenTheLeastShareAndOne) {
  const OdometryNoiseScale perfect = after(500, 0.0, {}, 1);
  EXPECT_EQ(perfect.translation, kLeast);
  EXPECT_EQ(perfect.rotation, kLeast);
  const OdometryNoiseScale awful =
      updated_noise_scale({0.95, 0.95}, kStep, {}, kPrior, {0.3, 0.3, 0.3}, 0.01 * kPrior, kLeast);
  EXPECT_EQ(awful.translation, 1.0);
  EXPECT_EQ(awful.rotation, 1.0);
}

TEST(OdometryNoiseScale, OneSlipTellsLittle) {
  const OdometryNoiseScale before{0.3, 0.3};
  const Eigen::Matrix3d prior = 0.09 * kPrior;
  const OdometryNoiseScale slipped =
      updated_noise_scale(before, kStep, {}, prior, {1.0, 0.0, 1.0}, 0.01 * prior, kLeast);
  EXPECT_GT(slipped.rotation, 0.3);
  EXPECT_LT(slipped.rotation, 0.4);
  EXPECT_GT(slipped.translation, 0.3);
  EXPECT_LT(slipped.translation, 0.4);
}

/// Along x, in any frame.
TEST(OdometryNoiseScale, WhatTheMatchCouldNotTellTeachesNothing) {
  for (const double heading : {0.0, 0.5, 2.0}) {
    Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
    turned.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(heading).toRotationMatrix();
    const Eigen::Matrix3d posterior =
        turned * diagonal_covariance(8e-4, 1e-5, 1e-5) * turned.transpose();
    const auto scale_with = [&](double off_x, double off_y) {
      const Eigen::Vector2d off = Eigen::Rotation2Dd(heading) * Eigen::Vector2d(off_x, off_y);
      return updated_noise_scale({0.5, 0.5}, kStep, {}, kPrior, {off.x(), off.y(), 0.0}, posterior,
                                 kLeast)
          .translation;
    };
    EXPECT_NEAR(scale_with(0.3, 0.0), scale_with(0.0, 0.0), 1e-12);
    EXPECT_LT(scale_with(0.0, 0.0), 0.5);
    EXPECT_GT(scale_with(0.0, 0.1), 0.5);
  }
  const OdometryNoiseScale nothing =
      updated_noise_scale({0.5, 0.5}, kStep, {}, kPrior, {0.3, 0.3, 0.3}, kPrior, kLeast);
  EXPECT_EQ(nothing.translation, 0.5);
  EXPECT_EQ(nothing.rotation, 0.5);
}

TEST(OdometryNoiseScale, ARobotAtRestTeachesNothing) {
  const OdometryNoiseScale rested = after(1000, 0.0, {0.7, 0.8}, 1, Pose2{});
  EXPECT_EQ(rested.translation, 0.7);
  EXPECT_EQ(rested.rotation, 0.8);
}

TEST(OdometryNoiseScale, WithoutAPriorThereIsNothingToLearn) {
  const OdometryNoiseScale same = updated_noise_scale(
      {0.5, 0.5}, kStep, {}, Eigen::Matrix3d::Zero(), {}, Eigen::Matrix3d::Zero(), kLeast);
  EXPECT_EQ(same.translation, 0.5);
  EXPECT_EQ(same.rotation, 0.5);
}

TEST(OdometryNoiseScale, ScalesStandardDeviations) {
  MotionEstimate estimate;
  estimate.covariance = diagonal_covariance(4.0, 4.0, 1.0);
  estimate.covariance(1, 2) = estimate.covariance(2, 1) = 0.5;
  estimate.floor = kPrior;
  const MotionEstimate scaled = scaled_by({0.5, 0.1}, estimate);
  EXPECT_NEAR(scaled.covariance(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(scaled.covariance(2, 2), 0.01, 1e-12);
  EXPECT_NEAR(scaled.covariance(1, 2), 0.5 * 0.05, 1e-12);
  EXPECT_NEAR(scaled.floor(0, 0), 0.25 * kPrior(0, 0), 1e-15);
}

}  // namespace
}  // namespace matchbox_slam
