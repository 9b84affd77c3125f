#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>

#include "lasers/scan_bundle.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

bool same_points(const PointScan& a, const PointScan& b) {
  if (a.points.size() != b.points.size() || a.free_rays.size() != b.free_rays.size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    if (a.points[i].position != b.points[i].position || a.points[i].normal != b.points[i].normal) {
      return false;
    }
  }
  return a.stamp == b.stamp;
}

/// Beams to the left, ahead and to the right, in the order of their angles.
LaserScan three_beams(double stamp, float right, float ahead, float left) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min = -0.5 * kPi;
  scan.angle_increment = 0.5 * kPi;
  scan.range_min = 0.1;
  scan.range_max = 30.0;
  scan.ranges = {right, ahead, left};
  return scan;
}

Eigen::Isometry3d mounted_at(double x, double y, double yaw) {
  return Eigen::Translation3d(x, y, 0.2) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

void expect_point(const PointScan& scan, std::size_t i, double x, double y) {
  EXPECT_NEAR(scan.points.at(i).position.x(), x, 1e-6) << i;
  EXPECT_NEAR(scan.points.at(i).position.y(), y, 1e-6) << i;
}

class ScanBundleTest : public testing::Test {
 protected:
  void assign(std::map<int, SecondaryScan> secondary) {
    ScanInput input;
    input.scan = three_beams(7.0, 1.0F, 2.0F, 3.0F);
    seen_.assign(input, mounted_at(0.5, 0.0, 0.0), {}, {}, std::move(secondary), projector_);
  }

  ScanProjector projector_;
  ScanBundle seen_;
};

TEST_F(ScanBundleTest, ThePrimaryScanLiesInTheBase) {
  assign({});
  ASSERT_EQ(seen_.points().points.size(), 3U);
  EXPECT_EQ(seen_.points().stamp, 7.0);
  expect_point(seen_.points(), 0, 0.5, -1.0);
  expect_point(seen_.points(), 1, 2.5, 0.0);
  expect_point(seen_.points(), 2, 0.5, 3.0);
  EXPECT_EQ(&seen_.all(), &seen_.points());
  EXPECT_TRUE(seen_.secondary().empty());
}

/// The base was 1 m back and a quarter of a turn to the right when it was taken.
TEST_F(ScanBundleTest, WhatOthersSawLiesInTheBaseAtThePrimaryScan) {
  const MeasuredScan other{three_beams(6.9, 1.0F, 2.0F, 4.0F), mounted_at(-0.3, 0.0, kPi), {}, {}};
  assign({{2, {other, {-1.0, 0.0, -0.5 * kPi}}}});
  ASSERT_EQ(seen_.points().points.size(), 3U) << "of the primary laser alone";
  ASSERT_EQ(seen_.all().points.size(), 6U);
  EXPECT_EQ(seen_.all().stamp, 7.0);
  expect_point(seen_.all(), 1, 2.5, 0.0);
  // In its own base (-0.3, 1), (-2.3, 0) and (-0.3, -4): x goes to -y, y to x, then 1 m back.
  expect_point(seen_.all(), 3, 0.0, 0.3);
  expect_point(seen_.all(), 4, -1.0, 2.3);
  expect_point(seen_.all(), 5, -5.0, 0.3);
}

TEST_F(ScanBundleTest, NothingStaysOfAnEarlierScan) {
  const MeasuredScan other{three_beams(6.9, 1.0F, 2.0F, 4.0F), mounted_at(0.0, 0.0, 0.0), {}, {}};
  assign({{1, {other, {}}}, {2, {other, {}}}});
  EXPECT_EQ(seen_.all().points.size(), 9U);
  assign({{1, {other, {}}}});
  EXPECT_EQ(seen_.all().points.size(), 6U);
  assign({});
  EXPECT_EQ(seen_.all().points.size(), 3U);
}

/// Put right, a scan is as if the motion had been known before.
TEST(ScanBundle, PointsFollowTheMotionThatIsPutRight) {
  LaserOptions laser;
  laser.beams = 200;
  laser.time_increment = 2e-4;
  const World world = make_rooms_world(3);
  ScanInput input;
  input.scan = ideal_scan(world, laser, {1.5, 1.5, 0.3}, 5.0);
  input.laser_motion = mounted_at(0.0, 0.01, 0.002);
  const Eigen::Isometry3d base_from_laser = laser.base_from_laser();
  const ProjectionOptions options;
  const Pose2 predicted{0.02, 0.0, 0.0};
  const Pose2 moved{0.03, 0.001, 0.02};
  ScanProjector projector;
  ScanBundle seen;
  seen.assign(input, base_from_laser, predicted, options, {}, projector);
  const auto projected = [&](const Pose2& motion) {
    return project_scan(input.scan, base_from_laser, motion, options, input.laser_motion);
  };
  EXPECT_TRUE(same_points(seen.points(), projected(predicted)));
  seen.correct_motion(predicted, projector);
  EXPECT_TRUE(same_points(seen.points(), projected(predicted)));
  seen.correct_motion(moved, projector);
  EXPECT_TRUE(same_points(seen.points(), projected(moved)));
  EXPECT_FALSE(same_points(seen.points(), projected(predicted)));
  EXPECT_EQ(seen.primary().motion, moved);
  EXPECT_TRUE(same_points(project_scan(seen.primary()), seen.points()));
}

}  // namespace
}  // namespace matchbox_slam
