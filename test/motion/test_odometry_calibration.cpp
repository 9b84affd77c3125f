#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/motion/odometry_calibration.hpp"

namespace matchbox_slam {
namespace {

Eigen::Matrix3d diagonal(double x, double y, double theta) {
  return Eigen::Vector3d(x, y, theta).asDiagonal();
}

/// A robot whose odometry tells too little or too much, and is noisy besides.
struct Drive {
  Eigen::Vector3d missing = {-0.01, 0.02, -0.003};
  double way_noise = 0.02;    // m/sqrt(m)
  double turn_noise = 0.01;   // rad/sqrt(m)
  double match_noise = 1e-3;  // m, rad
  double speed = 0.5;         // m/s
  double rate = 20.0;         // scans a second
  Eigen::Matrix3d prior = diagonal(4e-4, 4e-4, 1e-4);
  Eigen::Matrix3d posterior = diagonal(1e-6, 1e-6, 1e-6);
  Pose2 start;
};

/// What is known after so many metres, a turn to the left or to the right every 8 m.
OdometryCalibration after(double metres, const Drive& drive, OdometryCalibration calibration = {},
                          std::uint64_t seed = 1) {
  Random random(seed);
  Pose2 pose = drive.start;
  const double step = drive.speed / drive.rate;
  double stamp = 0.0;
  for (double way = 0.0; way < metres; way += step) {
    const bool turns = std::fmod(way, 8.0) < 1.0;
    const double side = std::fmod(way, 16.0) < 8.0 ? 1.0 : -1.0;
    const Pose2 moved{step, 0.0, turns ? 1.5 * side * step : 0.0};
    pose = pose * moved;
    const double noise = std::sqrt(step);
    // Of a share so small that the rest does not matter.
    const Pose2 told{
        (1.0 - drive.missing[0]) * moved.x + drive.way_noise * noise * random.gaussian(), 0.0,
        (1.0 - drive.missing[1]) * moved.theta - drive.missing[2] * moved.x +
            drive.turn_noise * noise * random.gaussian()};
    const Pose2 matched{pose.x + drive.match_noise * random.gaussian(),
                        pose.y + drive.match_noise * random.gaussian(),
                        pose.theta + drive.match_noise * random.gaussian()};
    calibration = calibrate(calibration, {stamp, stamp + 1.0 / drive.rate, told, matched,
                                          drive.prior, drive.posterior});
    stamp += 1.0 / drive.rate;
  }
  return calibration;
}

TEST(OdometryCalibration, PutsBackWhatIsMissing) {
  OdometryCalibration calibration;
  calibration.missing = {0.1, 0.0, 0.0};
  EXPECT_NEAR(calibrated(calibration, {1.0, 2.0, 0.5}).x, 1.1, 1e-12);
  EXPECT_NEAR(calibrated(calibration, {1.0, 2.0, 0.5}).y, 2.2, 1e-12);
  calibration.missing = {0.0, 0.1, 0.2};
  EXPECT_NEAR(calibrated(calibration, {1.0, 0.0, 0.5}).theta, 0.5 + 0.05 + 0.2, 1e-12);
  EXPECT_NEAR(calibrated(calibration, {-1.0, 0.0, 0.0}).theta, -0.2, 1e-12);
  // On an arc, of which a long step is the chord.
  const Pose2 bent = calibrated(calibration, {1.0, 0.0, 0.0});
  EXPECT_NEAR(std::atan2(bent.y, bent.x), 0.1, 1e-12);
  EXPECT_NEAR(bent.translation().norm(), 1.0, 1e-12);
}

/// By about what is left to be unsure of.
TEST(OdometryCalibration, FindsSystematicErrorsInNoise) {
  const Drive drive;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const OdometryCalibration found = after(200.0, drive, {}, seed);
    const Eigen::Vector3d off = found.missing - drive.missing;
    EXPECT_LT(std::abs(off[0]), 0.0036) << seed;  // 0.0025
    EXPECT_LT(std::abs(off[1]), 0.0046) << seed;  // 0.0031
    EXPECT_LT(std::abs(off[2]), 0.0015) << seed;  // 0.0010
    EXPECT_LT(off.dot(found.covariance.inverse() * off), 16.27) << seed;
    EXPECT_NEAR(std::sqrt(found.noise[0]), drive.way_noise, 0.005) << seed;  // 0.0036
  }
}

/// As it would where it took the noise of each step for the step.
TEST(OdometryCalibration, OdometryWithoutSystematicErrorsHasNone) {
  for (const double rate : {5.0, 20.0, 80.0}) {
    Drive drive;
    drive.missing.setZero();
    drive.rate = rate;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    constexpr int kSeeds = 20;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      mean += after(100.0, drive, {}, static_cast<std::uint64_t>(seed)).missing / kSeeds;
    }
    EXPECT_LT(std::abs(mean[0]), 0.0011) << rate;  // 0.0007
    EXPECT_LT(std::abs(mean[1]), 0.0010) << rate;  // 0.0007
    EXPECT_LT(std::abs(mean[2]), 0.0004) << rate;  // 0.0002
  }
}

TEST(OdometryCalibration, WhereTheFrameLiesDoesNotMatter) {
  Drive drive;
  const OdometryCalibration here = after(50.0, drive);
  drive.start = {30.0, -20.0, 2.0};
  const OdometryCalibration there = after(50.0, drive);
  EXPECT_NEAR((here.missing - there.missing).norm(), 0.0, 2e-4);
}

/// In a corridor the answer along it is the prior's own.
TEST(OdometryCalibration, WhatTheMatchCouldNotTellTeachesNothing) {
  Drive drive;
  for (const double heading : {0.0, 0.7}) {
    Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
    turned.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(heading).toRotationMatrix();
    drive.posterior = turned * diagonal(3.9e-4, 1e-6, 1e-6) * turned.transpose();
    const OdometryCalibration before;
    const OdometryCalibration found = after(50.0, drive, before);
    EXPECT_EQ(found.missing, before.missing);
    EXPECT_EQ(found.covariance, before.covariance);
  }
}

TEST(OdometryCalibration, StretchesDoNotSpanWhatWasNotMatched) {
  const Drive drive;
  OdometryCalibration calibration = after(50.5, drive);
  const Eigen::Vector3d before = calibration.missing;
  // The stamp before is that of a scan which it was not told of; the way to it is missing.
  calibration =
      calibrate(calibration,
                {200.0, 200.05, {1.0, 0.0, 0.0}, {500.0, 0.0, 0.0}, drive.prior, drive.posterior});
  EXPECT_EQ(calibration.missing, before);
}

TEST(OdometryCalibration, OneSlipTellsLittle) {
  const Drive drive;
  OdometryCalibration calibration = after(100.0, drive);
  const Eigen::Vector3d before = calibration.missing;
  const Pose2 pose{3.0, 1.0, 0.2};
  calibration = calibrate(calibration, {0.0, 1.0, {}, pose, drive.prior, drive.posterior});
  // It reports a metre, and a radian, and did not move.
  calibration =
      calibrate(calibration, {1.0, 2.0, {1.0, 0.0, 1.0}, pose, drive.prior, drive.posterior});
  const Eigen::Vector3d moved = calibration.missing - before;
  EXPECT_NE(moved[0], 0.0);
  EXPECT_LT(std::abs(moved[0]), 0.0015);  // 0.0010
  EXPECT_LT(std::abs(moved[1]), 0.008);   // 0.0053
}

/// Other wheels.
TEST(OdometryCalibration, FollowsErrorsThatChange) {
  Drive drive;
  const OdometryCalibration before = after(300.0, drive);
  drive.missing[0] = 0.02;
  const OdometryCalibration found = after(300.0, drive, before, 2);
  EXPECT_NEAR(found.missing[0], 0.02, 0.005);  // 0.0033
}

}  // namespace
}  // namespace matchbox_slam
