#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "matchbox_slam/matching/key_scan.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

TEST(KeyScan, HasAFieldOfItsPointsAndTheWallsBetweenThem) {
  PointScan scan;
  for (int i = 0; i < 2; ++i) {
    ScanPoint point;
    point.position = {2.0, 1.0 * i};
    point.origin = Eigen::Vector2d::Zero();
    point.normal = {-1.0, 0.0};
    point.joined_to_next = i == 0;
    scan.points.push_back(point);
  }
  const KeyScan key(scan);
  const std::shared_ptr<const LikelihoodField> field = key.field();
  for (const double y : {0.02, 0.5, 0.98}) {
    EXPECT_GT(field->likelihood(field->geometry().cell_at({2.0, y})), 150) << y;
    EXPECT_EQ(field->likelihood(field->geometry().cell_at({1.0, y})), 0) << y;
  }
  EXPECT_EQ(key.field(), field) << "kept";
}

TEST(KeyScan, MakesItsPointsOfWhatWasMeasured) {
  const World world = make_rooms_world(7);
  const LaserOptions laser;
  const PoseAtTime at_rest = [](double /*stamp*/) { return Pose2{}; };
  MeasuredScan measured{simulate_scan(world, laser, at_rest, 3.0, 1).scan,
                        laser.base_from_laser(),
                        {0.1, 0.0, 0.05},
                        {}};
  measured.options.free_range = 2.0;
  const KeyScan key(measured, 5, 1);
  const PointScan expected =
      project_scan(measured.scan, measured.base_from_laser, measured.motion, measured.options);
  const std::shared_ptr<const PointScan> points = key.points();
  EXPECT_EQ(points->stamp, 3.0);
  ASSERT_EQ(points->points.size(), expected.points.size());
  for (std::size_t i = 0; i < expected.points.size(); ++i) {
    ASSERT_EQ(points->points[i].position, expected.points[i].position);
    ASSERT_EQ(points->points[i].normal, expected.points[i].normal);
  }
  EXPECT_EQ(key.points(), points) << "kept";
  EXPECT_EQ(key.id(), 5U);
  EXPECT_EQ(key.laser(), 1);
}

void expect_same(const MeasuredScan& a, const MeasuredScan& b) {
  EXPECT_EQ(a.scan.stamp, b.scan.stamp);
  EXPECT_EQ(a.scan.angle_min, b.scan.angle_min);
  EXPECT_EQ(a.scan.angle_increment, b.scan.angle_increment);
  EXPECT_EQ(a.scan.time_increment, b.scan.time_increment);
  EXPECT_EQ(a.scan.range_min, b.scan.range_min);
  EXPECT_EQ(a.scan.range_max, b.scan.range_max);
  EXPECT_EQ(a.scan.ranges, b.scan.ranges);
  EXPECT_EQ(a.base_from_laser.matrix(), b.base_from_laser.matrix());
  EXPECT_EQ(a.laser_motion.matrix(), b.laser_motion.matrix());
  EXPECT_EQ(a.motion, b.motion);
  EXPECT_TRUE(a.options == b.options);
}

TEST(KeyScan, WhatScansShareIsToldOfEachAsItWas) {
  std::vector<MeasuredScan> all(10);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].scan.ranges = {1.0F, 2.0F + static_cast<float>(i)};
    all[i].scan.stamp = 10.0 + static_cast<double>(i);
    all[i].motion.x = 0.01 * static_cast<double>(i);
  }
  all[2].scan.angle_min = -1.0;
  all[3].scan.angle_increment = 0.1;
  all[4].scan.time_increment = 1e-4;
  all[5].scan.range_min = 0.1;
  all[6].scan.range_max = 30.0;
  all[7].base_from_laser.translation().x() = 0.2;
  all[8].laser_motion.translation().z() = 0.01;
  all[9].options.max_range = 12.0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    SCOPED_TRACE(i);
    const std::shared_ptr<KeyScanCache> cache = make_key_scan_cache();
    const KeyScan before(all[0], 0, 0, cache);
    const KeyScan key(all[i], 0, 0, cache);
    expect_same(*before.measured(), all[0]);
    expect_same(*key.measured(), all[i]);
    EXPECT_EQ(key.base_from_laser() == before.base_from_laser(), i == 1) << "shared";
  }
}

TEST(KeyScan, SharesItsCacheWithOthersButNotWhatIsInIt) {
  const MatchScene& scene = rooms_scene();
  const std::shared_ptr<KeyScanCache> cache = make_key_scan_cache();
  PointScan half = scene.scan;
  half.points.resize(half.points.size() / 2);
  const KeyScan whole(scene.scan, 0, 0, cache);
  const KeyScan part(half, 0, 0, cache);  // with the same id
  EXPECT_GT(whole.field()->surface_cells().size(), part.field()->surface_cells().size() + 50);
}

TEST(KeyScan, LeavesOutWhatNoLaserMeasures) {
  const MatchScene& scene = rooms_scene();
  const KeyScan key(scene.scan);
  for (const double bad : {std::nan(""), 1e6, 1e30, 1e308}) {
    PointScan scan = scene.scan;
    ScanPoint point = scan.points.front();
    point.position.x() = bad;
    point.joined_to_next = true;
    scan.points.front().joined_to_next = true;
    scan.points.insert(scan.points.begin() + 1, point);
    const KeyScan other(scan);
    EXPECT_LE(other.field()->surface_cells().size(), key.field()->surface_cells().size());
    EXPECT_GE(other.field()->surface_cells().size() + 30, key.field()->surface_cells().size());
  }
}

}  // namespace
}  // namespace matchbox_slam
