#include <gtest/gtest.h>

#include <memory>

#include "slam/mutual_fit.hpp"

namespace matchbox_slam {
namespace {

/// Points 1 cm apart on a line along y, seen from the origin, of one metre of wall each.
void add_wall(PointScan& scan, double x, double from_y, double to_y) {
  for (double y = from_y; y < to_y - 1e-9; y += 0.01) {
    ScanPoint point;
    point.position = {x, y};
    point.origin = Eigen::Vector2d::Zero();
    point.normal = {x > 0.0 ? -1.0 : 1.0, 0.0};
    point.weight = 1.0;
    scan.points.push_back(point);
  }
}

PlacedScans seen_at(const PointScan& scan, const Pose2& map_from_base) {
  return {{std::make_shared<const KeyScan>(scan), map_from_base}};
}

PlacedScans seen(const PointScan& scan) { return seen_at(scan, {}); }

PointScan wall_ahead() {
  PointScan scan;
  add_wall(scan, 2.0, -1.0, 1.0);
  return scan;
}

TEST(GroundShares, CountWhatLiesOnMappedGroundAndOffItsWalls) {
  const SlamMap map = [] {
    SlamMap drawn({}, {});
    insert_scan(wall_ahead(), {}, {}, drawn);
    return drawn;
  }();
  PointScan scan;
  add_wall(scan, 2.0, -0.2, 0.2);    // 40 on the wall
  add_wall(scan, 1.5, -0.15, 0.15);  // 30 before it, where it is free
  add_wall(scan, 3.0, -0.15, 0.15);  // 30 behind it, where nothing is known
  const GroundShares shares = ground_shares(scan, {}, map);
  EXPECT_NEAR(shares.mapped, 0.7, 1e-9);
  EXPECT_NEAR(shares.off_walls, 30.0 / 70.0, 1e-9);
  const GroundShares elsewhere = ground_shares(scan, {0.0, 50.0, 0.0}, map);
  EXPECT_EQ(elsewhere.mapped, 0.0);
  EXPECT_EQ(elsewhere.off_walls, 0.0);
  EXPECT_EQ(ground_shares({}, {}, map).mapped, 0.0);
}

TEST(GroundShares, AreOfTheScanWhereItIs) {
  SlamMap map({}, {});
  insert_scan(wall_ahead(), {}, {}, map);
  EXPECT_EQ(ground_shares(wall_ahead(), {}, map).off_walls, 0.0);
  EXPECT_EQ(ground_shares(wall_ahead(), {-0.5, 0.0, 0.0}, map).off_walls, 1.0);
  EXPECT_EQ(ground_shares(wall_ahead(), {-0.05, 0.0, 0.0}, map).off_walls, 0.0) << "a cell";
}

/// A quarter of what was seen there then is a box that is not there now, which no beam says that
/// ends before it.
TEST(MutualFit, IsLessByWhatEitherKnowsBetter) {
  PointScan with_box = wall_ahead();
  with_box.points.erase(with_box.points.begin() + 130, with_box.points.end());
  add_wall(with_box, 1.5, 0.3, 0.75);
  const double share = 45.0 / 175.0;
  EXPECT_NEAR(mutual_fit(seen(wall_ahead()), seen(with_box), 1.0), 1.0 - share, 1e-9);
  EXPECT_NEAR(mutual_fit(seen(with_box), seen(wall_ahead()), 1.0), 1.0 - share, 1e-9);
  EXPECT_NEAR(mutual_fit(seen(wall_ahead()), seen(wall_ahead()), 0.9), 0.9, 1e-9);
}

TEST(MutualFit, IsOfTheGroundThatBothSaw) {
  PointScan all_around = wall_ahead();
  add_wall(all_around, -3.0, -1.0, 1.0);  // as much again
  EXPECT_NEAR(mutual_fit(seen(all_around), seen(wall_ahead()), 0.45), 0.9, 1e-9);
  EXPECT_NEAR(mutual_fit(seen(wall_ahead()), seen(all_around), 0.9), 0.9, 1e-9);
}

TEST(MutualFit, IsOfScansWhereTheyAre) {
  const Pose2 there{3.0, -2.0, 0.0};
  EXPECT_NEAR(mutual_fit(seen_at(wall_ahead(), there), seen_at(wall_ahead(), there), 0.9), 0.9,
              1e-9);
  EXPECT_EQ(mutual_fit(seen_at(wall_ahead(), there), seen(wall_ahead()), 0.9), 0.0)
      << "hardly any ground was seen both times";
}

}  // namespace
}  // namespace matchbox_slam
