#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

TEST(WrapAngle, LeavesAnglesOfTheFirstTurnAsTheyAre) {
  const double just_below_pi = std::nextafter(kPi, 0.0);
  for (const double angle : {0.0, 1e-300, -1e-17, 1.0, -3.0, -kPi, just_below_pi}) {
    EXPECT_EQ(wrap_angle(angle), angle);
  }
}

TEST(WrapAngle, TheUpperEndBelongsToTheNextTurn) {
  for (const double angle : {kPi, 3.0 * kPi, -3.0 * kPi, 101.0 * kPi}) {
    EXPECT_NEAR(std::abs(wrap_angle(angle)), kPi, 1e-13) << angle;
  }
  EXPECT_EQ(wrap_angle(kPi), -kPi);
  EXPECT_LT(wrap_angle(std::nextafter(-kPi, -4.0)), kPi);
  EXPECT_GT(wrap_angle(std::nextafter(-kPi, -4.0)), 3.14);
  EXPECT_LT(wrap_angle(std::nextafter(kPi, 4.0)), -3.14);
}

TEST(WrapAngle, StaysInItsIntervalAndDiffersByWholeTurns) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double magnitude = std::pow(10.0, random.uniform(-3.0, 9.0));
    const double angle = random.uniform(-magnitude, magnitude);
    const double wrapped = wrap_angle(angle);
    ASSERT_GE(wrapped, -kPi) << angle;
    ASSERT_LT(wrapped, kPi) << angle;
    const double tolerance = 1e-15 * (1.0 + std::abs(angle));
    ASSERT_NEAR(std::cos(wrapped), std::cos(angle), tolerance) << angle;
    ASSERT_NEAR(std::sin(wrapped), std::sin(angle), tolerance) << angle;
  }
}

TEST(WrapAngle, HugeAnglesStayInTheInterval) {
  for (const double angle : {1e15, -1e15, 1e18, -1e300, std::numeric_limits<double>::max()}) {
    EXPECT_GE(wrap_angle(angle), -kPi) << angle;
    EXPECT_LT(wrap_angle(angle), kPi) << angle;
  }
}

TEST(WrapAngle, WhatIsNotANumberStaysSo) {
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::infinity())));
}

TEST(Degrees, AreConvertedBothWays) {
  EXPECT_DOUBLE_EQ(degrees_to_radians(180.0), kPi);
  EXPECT_DOUBLE_EQ(degrees_to_radians(-90.0), -0.5 * kPi);
  EXPECT_DOUBLE_EQ(radians_to_degrees(degrees_to_radians(12.5)), 12.5);
}

}  // namespace
}  // namespace matchbox_slam
