#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "simulation/wall_segment.hpp"

namespace matchbox_slam {
namespace {

constexpr int kBeams = 10000;

/// A wall along the y axis.
WallSegment wall_of(const WallSurface& surface) {
  return {{0.0, -1.0}, {0.0, 1.0}, false, surface};
}

/// Share of the beams that pass at an angle to the normal.
double share_that_passes(const WallSurface& surface, double incidence) {
  int passed = 0;
  for (std::uint64_t beam = 0; beam < kBeams; ++beam) {
    passed +=
        lets_pass(wall_of(surface), {std::cos(incidence), std::sin(incidence)}, mix_seed(7, beam))
            ? 1
            : 0;
  }
  return static_cast<double>(passed) / kBeams;
}

TEST(WallSegment, IsOpaqueUnlessItSaysOtherwise) {
  for (const double incidence : {0.0, 0.7, 1.57}) {
    EXPECT_EQ(share_that_passes({}, incidence), 0.0);
  }
  EXPECT_EQ(depth_of_return(wall_of({}), 1), 0.0);
}

TEST(WallSegment, LetsTheShareOfBeamsPassThatItSays) {
  WallSurface railing;
  railing.passing = 0.3;
  for (const double incidence : {0.0, 0.7, -1.2}) {
    EXPECT_NEAR(share_that_passes(railing, incidence), 0.3, 0.02);
  }
}

TEST(WallSegment, OfGlassReturnsOnlyBeamsNearItsNormal) {
  WallSurface glass;
  glass.widest_incidence = degrees_to_radians(12.0);
  for (const double degrees : {0.0, 11.9, -11.9, 180.0, 168.1}) {
    EXPECT_EQ(share_that_passes(glass, degrees_to_radians(degrees)), 0.0) << degrees;
  }
  for (const double degrees : {12.1, -12.1, 45.0, 89.0, 167.9}) {
    EXPECT_EQ(share_that_passes(glass, degrees_to_radians(degrees)), 1.0) << degrees;
  }
}

TEST(WallSegment, WithDepthReturnsFromAnywhereInIt) {
  WallSurface hedge;
  hedge.depth = 0.4;
  double sum = 0.0;
  double least = 1.0;
  double most = 0.0;
  for (std::uint64_t beam = 0; beam < kBeams; ++beam) {
    const double depth = depth_of_return(wall_of(hedge), mix_seed(7, beam));
    sum += depth;
    least = std::min(least, depth);
    most = std::max(most, depth);
  }
  EXPECT_NEAR(sum / kBeams, 0.2, 0.005);
  EXPECT_LT(least, 0.01);
  EXPECT_GE(least, 0.0);
  EXPECT_GT(most, 0.39);
  EXPECT_LE(most, 0.4);
}

}  // namespace
}  // namespace matchbox_slam
