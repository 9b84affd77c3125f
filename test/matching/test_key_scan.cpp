#include <gtest/gtest.h>

#include <cmath>
#include <thread>

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
  const KeyScan key(scan, {1.0, 0.0, kPi / 2.0});
  const LikelihoodField& field = key.field();
  for (const double y : {0.02, 0.5, 0.98}) {
    EXPECT_GT(field.likelihood(field.geometry().cell_at({2.0, y})), 150) << y;
    EXPECT_EQ(field.likelihood(field.geometry().cell_at({1.0, y})), 0) << y;
  }
  const KeyScan copy = key;  // NOLINT(performance-unnecessary-copy-initialization): under test
  EXPECT_EQ(&copy.field(), &field);
}

TEST(KeyScan, MakesItsFieldOnceForAllThreads) {
  const MatchScene scene = make_match_scene(make_rooms_world(7), LaserOptions{}, 15.0, 1);
  const KeyScan key(scene.scan, scene.map_from_base);
  std::vector<std::size_t> surfaces(4);
  std::vector<std::thread> threads;
  for (std::size_t& count : surfaces) {
    threads.emplace_back([&] { count = key.field().surface_cells().size(); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_GT(surfaces[0], 100U);
  EXPECT_EQ(surfaces, std::vector<std::size_t>(4, surfaces[0]));
  // Made twice, it would have every hit twice.
  const KeyScan alone(scene.scan, scene.map_from_base);
  for (const Cell& cell : key.field().surface_cells()) {
    Surface surface;
    Surface expected;
    ASSERT_TRUE(key.field().nearest_surface(cell, surface));
    ASSERT_TRUE(alone.field().nearest_surface(cell, expected));
    ASSERT_EQ(surface.hits, expected.hits);
  }
}

TEST(KeyScan, LeavesOutWhatNoLaserMeasures) {
  const MatchScene scene = make_match_scene(make_rooms_world(7), LaserOptions{}, 15.0, 1);
  const KeyScan key(scene.scan, scene.map_from_base);
  for (const double bad : {std::nan(""), 1e6, 1e30, 1e308}) {
    PointScan scan = scene.scan;
    ScanPoint point = scan.points.front();
    point.position.x() = bad;
    point.joined_to_next = true;
    scan.points.front().joined_to_next = true;
    scan.points.insert(scan.points.begin() + 1, point);
    const KeyScan other(scan, scene.map_from_base);
    EXPECT_LE(other.field().surface_cells().size(), key.field().surface_cells().size());
    EXPECT_GE(other.field().surface_cells().size() + 30, key.field().surface_cells().size());
  }
}

}  // namespace
}  // namespace matchbox_slam
