#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {
namespace {

constexpr double kStep = 1.0 / 65534.0;  // of the stored form

TEST(OccupancyGrid, UnknownIsNotTheSameAsUndecided) {
  OccupancyGrid grid(0.05);
  EXPECT_FALSE(grid.is_known({3, -4}));
  EXPECT_EQ(grid.occupancy({3, -4}), 0.5);
  EXPECT_EQ(grid.stored({3, -4}), OccupancyGrid::kUnknown);
  grid.blend({3, -4}, 0.5, 1.0);
  EXPECT_TRUE(grid.is_known({3, -4}));
  EXPECT_NEAR(grid.occupancy({3, -4}), 0.5, kStep);
  EXPECT_FALSE(grid.is_known({4, -4})) << "a neighbour in the same tile";
}

TEST(OccupancyGrid, BlendGoesAFractionOfTheWay) {
  OccupancyGrid grid(0.05);
  EXPECT_NEAR(grid.blend({0, 0}, 1.0, 0.4), 0.7, kStep);
  EXPECT_NEAR(grid.occupancy({0, 0}), 0.7, kStep);
  EXPECT_NEAR(grid.blend({0, 0}, 0.0, 0.5), 0.35, kStep);
  EXPECT_NEAR(grid.blend({0, 0}, 0.85, 0.1), 0.40, 2 * kStep);
  EXPECT_NEAR(grid.occupancy({0, 0}), 0.40, 2 * kStep);
}

TEST(OccupancyGrid, ReachesBothEndsAndLeavesThemAgain) {
  OccupancyGrid grid(0.05);
  const Cell cell{-70, 65};
  for (const double end : {1.0, 0.0, 1.0}) {
    grid.blend(cell, end, 1.0);
    EXPECT_EQ(grid.occupancy(cell), end);
    EXPECT_TRUE(grid.is_known(cell)) << "free is stored apart from unknown";
    for (int i = 0; i < 1000; ++i) {
      grid.blend(cell, end, 0.3);
    }
    EXPECT_EQ(grid.occupancy(cell), end);
    // However often it was seen so, it changes its mind as fast as a new cell.
    EXPECT_NEAR(grid.blend(cell, 1.0 - end, 0.3), end + 0.3 * (1.0 - 2.0 * end), kStep);
  }
}

TEST(OccupancyGrid, StoresProbabilitiesInEqualSteps) {
  EXPECT_EQ(OccupancyGrid::to_probability(1), 0.0);
  EXPECT_EQ(OccupancyGrid::to_probability(65535), 1.0);
  EXPECT_EQ(OccupancyGrid::to_probability(OccupancyGrid::kUnknown), 0.5);
  EXPECT_DOUBLE_EQ(OccupancyGrid::to_probability(101) - OccupancyGrid::to_probability(100), kStep);
}

TEST(OccupancyGrid, KnownBoundsFitTightly) {
  OccupancyGrid grid(0.05);
  EXPECT_TRUE(grid.known_bounds().empty());
  grid.blend({-3, 10}, 1.0, 0.5);
  EXPECT_EQ(grid.known_bounds().min, (Cell{-3, 10}));
  EXPECT_EQ(grid.known_bounds().max, (Cell{-2, 11}));
  grid.blend({200, -150}, 0.0, 0.5);
  grid.blend({5, 5}, 0.5, 0.5);
  EXPECT_EQ(grid.known_bounds().min, (Cell{-3, -150}));
  EXPECT_EQ(grid.known_bounds().max, (Cell{201, 11}));
}

TEST(OccupancyGrid, KnownBoundsAreThoseOfAllCells) {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    OccupancyGrid grid(0.05);
    CellBox bounds;
    for (int k = 0; k <= i; ++k) {
      const Cell cell{static_cast<int>(random.uniform(-400.0, 400.0)),
                      static_cast<int>(random.uniform(-400.0, 400.0))};
      grid.blend(cell, 1.0, 0.5);
      bounds.include(cell);
    }
    EXPECT_EQ(grid.known_bounds().min, bounds.min);
    EXPECT_EQ(grid.known_bounds().max, bounds.max);
  }
}

TEST(OccupancyGrid, ACopyIsASnapshot) {
  OccupancyGrid grid(0.05);
  grid.blend({0, 0}, 1.0, 1.0);
  const OccupancyGrid snapshot = grid;
  grid.blend({0, 0}, 0.0, 1.0);
  grid.blend({1000, 0}, 0.0, 1.0);
  EXPECT_EQ(snapshot.occupancy({0, 0}), 1.0);
  EXPECT_FALSE(snapshot.is_known({1000, 0}));
}

}  // namespace
}  // namespace matchbox_slam
