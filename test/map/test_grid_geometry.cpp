#include <gtest/gtest.h>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/map/grid_geometry.hpp"

namespace matchbox_slam {
namespace {

TEST(GridGeometry, CellZeroHasItsLowerLeftCornerAtTheOrigin) {
  const GridGeometry geometry(0.25);  // a power of two, so that corners are exact
  EXPECT_EQ(geometry.cell_at({0.0, 0.0}), (Cell{0, 0}));
  EXPECT_EQ(geometry.cell_at({0.249, 0.25}), (Cell{0, 1}));
  EXPECT_EQ(geometry.cell_at({-1e-12, -0.25}), (Cell{-1, -1}));
  EXPECT_EQ(geometry.cell_at({-0.2501, 7.0}), (Cell{-2, 28}));
  EXPECT_EQ(geometry.corner({-2, 28}), Eigen::Vector2d(-0.5, 7.0));
  EXPECT_EQ(geometry.center({-2, 28}), Eigen::Vector2d(-0.375, 7.125));
}

TEST(GridGeometry, TheCenterOfACellLiesInThatCell) {
  for (const double resolution : {0.05, 0.03, 0.1, 1.0}) {
    const GridGeometry geometry(resolution);
    for (int i = -3000; i <= 3000; ++i) {
      const Cell cell{i, -7 * i};
      ASSERT_EQ(geometry.cell_at(geometry.center(cell)), cell) << resolution;
    }
  }
}

TEST(GridGeometry, EveryPointLiesWithinHalfACellOfItsCenter) {
  const GridGeometry geometry(0.05);
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const Eigen::Vector2d point(random.uniform(-500.0, 500.0), random.uniform(-500.0, 500.0));
    const Eigen::Vector2d off = point - geometry.center(geometry.cell_at(point));
    ASSERT_LE(off.cwiseAbs().maxCoeff(), 0.025 + 1e-9);
  }
}

TEST(CellBox, HoldsItsLowerButNotItsUpperEnd) {
  const CellBox box{{-2, 3}, {1, 5}};
  EXPECT_EQ(box.width(), 3);
  EXPECT_EQ(box.height(), 2);
  EXPECT_FALSE(box.empty());
  EXPECT_TRUE(box.contains({-2, 3}));
  EXPECT_TRUE(box.contains({0, 4}));
  EXPECT_FALSE(box.contains({1, 4}));
  EXPECT_FALSE(box.contains({0, 5}));
  EXPECT_FALSE(box.contains({-3, 4}));
  EXPECT_TRUE(CellBox{}.empty());
  EXPECT_TRUE((CellBox{{2, 0}, {1, 9}}.empty()));
}

}  // namespace
}  // namespace matchbox_slam
