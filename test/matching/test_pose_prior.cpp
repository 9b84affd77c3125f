#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "matchbox_slam/matching/pose_prior.hpp"

namespace matchbox_slam {
namespace {

TEST(PriorPenalty, IsThatOfAGaussianNearThePrior) {
  for (double square = 0.0; square <= kPriorKernelThreshold; square += 0.01) {
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
  EXPECT_NEAR(last, 3.0 * kPriorKernelThreshold, 1e-9);
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(prior_penalty(infinite), 3.0 * kPriorKernelThreshold);
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

/// Metres of wall, in pieces of a tenth.
PointScan scan_of_wall(int tenths, const Eigen::Vector2d& normal, double spacing) {
  ScanPoint point{{2.0, 0.0}};
  point.normal = normal;
  point.weight = 0.1;
  point.spacing = spacing;
  PointScan scan;
  scan.points.assign(static_cast<std::size_t>(tenths), point);
  return scan;
}

TEST(WeightBeside, IsTheMoreTheLessWallAScanTellsOf) {
  const Eigen::Vector2d normal(-1.0, 0.0);
  EXPECT_EQ(weight_beside(scan_of_wall(200, normal, 0.5), 0.03), 0.03);
  EXPECT_NEAR(weight_beside(scan_of_wall(50, normal, 0.5), 0.03), 0.03, 1e-12);
  EXPECT_NEAR(weight_beside(scan_of_wall(10, normal, 0.5), 0.03), 0.15, 1e-12);
  EXPECT_NEAR(weight_beside(scan_of_wall(10, {0.0, 0.0}, 0.5), 0.03), 1.5, 1e-12)
      << "of which a tenth is known";
  EXPECT_TRUE(std::isfinite(weight_beside({}, 0.03)));
}

}  // namespace
}  // namespace matchbox_slam
