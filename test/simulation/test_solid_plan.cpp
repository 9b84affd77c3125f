#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "simulation/solid_plan.hpp"

namespace matchbox_slam {
namespace {

bool has(const std::vector<WallSegment>& walls, const Eigen::Vector2d& start,
         const Eigen::Vector2d& end) {
  return std::any_of(walls.begin(), walls.end(), [&](const WallSegment& wall) {
    return wall.start.isApprox(start, 1e-12) && wall.end.isApprox(end, 1e-12);
  });
}

TEST(SolidPlan, SpacesThatOverlapAreOne) {
  SolidPlan plan({10.0, 10.0});
  plan.cut({1.0, 1.0}, {5.0, 3.0});
  plan.cut({5.0, 2.0}, {3.0, 7.0});  // from any corner to the opposite one
  const std::vector<WallSegment> walls = plan.walls();
  EXPECT_EQ(walls.size(), 6U);
  EXPECT_TRUE(has(walls, {1.0, 1.0}, {5.0, 1.0}));
  EXPECT_TRUE(has(walls, {1.0, 3.0}, {3.0, 3.0}));
  EXPECT_TRUE(has(walls, {3.0, 7.0}, {5.0, 7.0}));
  EXPECT_TRUE(has(walls, {1.0, 1.0}, {1.0, 3.0}));
  EXPECT_TRUE(has(walls, {3.0, 3.0}, {3.0, 7.0}));
  EXPECT_TRUE(has(walls, {5.0, 1.0}, {5.0, 7.0}));
}

TEST(SolidPlan, AThingInASpaceHasFourWallsAndOneAtItsWallIsPartOfThat) {
  SolidPlan plan({10.0, 10.0});
  plan.cut({1.0, 1.0}, {9.0, 9.0});
  plan.fill({4.0, 4.0}, {4.3, 4.5});
  EXPECT_EQ(plan.walls().size(), 8U);
  plan.fill({1.0, 5.0}, {1.4, 6.0});
  const std::vector<WallSegment> walls = plan.walls();
  EXPECT_EQ(walls.size(), 12U);
  EXPECT_TRUE(has(walls, {1.0, 1.0}, {1.0, 5.0}));
  EXPECT_TRUE(has(walls, {1.4, 5.0}, {1.4, 6.0}));
}

TEST(SolidPlan, WhatLiesOutsideStaysSolid) {
  SolidPlan plan({2.0, 1.0});
  plan.cut({-5.0, -5.0}, {50.0, 50.0});
  const std::vector<WallSegment> walls = plan.walls();
  EXPECT_EQ(walls.size(), 4U);
  EXPECT_TRUE(has(walls, {0.0, 1.0}, {2.0, 1.0}));
  EXPECT_TRUE(has(walls, {2.0, 0.0}, {2.0, 1.0}));
}

}  // namespace
}  // namespace matchbox_slam
