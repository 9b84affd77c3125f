#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "matchbox_slam/matching/pose_prior.hpp"

namespace matchbox_slam {
namespace {

TEST(PriorPenalty, IsThatOfAGaussianNearThePrior) {
  for (double square = 0.0; square <= kPriorsWord; square += 0.01) {
    EXPECT_EQ(prior_penalty(square), square);
    EXPECT_EQ(prior_weight_at(square), 1.0);
  }
}

TEST(PriorPenalty, NeverFallsAndSaturates) {
  double last = 0.0;
  for (double square = 1e-3; square < 1e20; square *= 1.001) {
    EXPECT_GE(prior_penalty(square), last) << square;
    last = prior_penalty(square);
  }
  EXPECT_NEAR(last, 3.0 * kPriorsWord, 1e-9);
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(prior_penalty(infinite), 3.0 * kPriorsWord);
  EXPECT_EQ(prior_weight_at(infinite), 0.0);
}

TEST(PriorPenalty, ItsSlopeIsTheWeight) {
  constexpr double kStep = 1e-4;
  for (double square = 0.05; square < 200.0; square *= 1.1) {
    const double slope =
        (prior_penalty(square + kStep) - prior_penalty(square - kStep)) / (2.0 * kStep);
    EXPECT_NEAR(prior_weight_at(square), slope, 1e-4) << square;
  }
}

}  // namespace
}  // namespace matchbox_slam
