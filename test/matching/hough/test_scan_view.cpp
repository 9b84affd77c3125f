#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"
#include "matching/hough/scan_view.hpp"

namespace matchbox_slam {
namespace {

/// A laser at (1, 0) that sees a wall 3 m away all over its left side.
PointScan half_circle(int beams) {
  PointScan scan;
  const Eigen::Vector2d origin(1.0, 0.0);
  for (int i = 0; i < beams; ++i) {
    const double angle = kPi * i / (beams - 1);
    ScanPoint point;
    point.position = origin + 3.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    point.origin = origin;
    scan.points.push_back(point);
  }
  return scan;
}

TEST(ScanView, KnowsTheSpaceBeforeTheWalls) {
  for (const int beams : {60, 180, 1000}) {
    const ScanView view(half_circle(beams));
    for (double angle = 0.05; angle < kPi - 0.05; angle += 0.013) {
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d origin(1.0, 0.0);
      EXPECT_NEAR(view.depth(origin + 1.0 * direction), 2.0, 1e-5) << beams << " " << angle;
      EXPECT_NEAR(view.depth(origin + 4.0 * direction), -1.0, 1e-5);
      EXPECT_EQ(view.depth(origin - 1.0 * direction), 0.0) << "nobody looked there";
    }
  }
}

TEST(ScanView, DoesNotGuessBetweenSparseBeams) {
  const ScanView view(half_circle(12));
  const Eigen::Vector2d between(1.0 + std::cos(0.4 * kPi / 11), std::sin(0.4 * kPi / 11));
  EXPECT_EQ(view.depth(between), 0.0);
}

TEST(ScanView, TellsTheShareOfContradictedWall) {
  const ScanView view(half_circle(500));
  HoughPoints points;
  points.x = {1.0F, 1.0F, 1.0F};
  points.y = {1.0F, 2.95F, 5.0F};  // in the free space, at the wall, behind it
  points.weight = {0.1F, 0.1F, 0.2F};
  EXPECT_NEAR(view.contradicted(points, {}), 0.25, 1e-6);
  EXPECT_NEAR(view.contradicted(points, {0.0, -3.0, 0.0}), 0.5, 1e-6);
  EXPECT_EQ(view.contradicted({}, {}), 0.0);
  EXPECT_EQ(ScanView({}).contradicted(points, {}), 0.0);
}

}  // namespace
}  // namespace matchbox_slam
