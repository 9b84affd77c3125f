#include <gtest/gtest.h>

#include <thread>

#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/simulation/make_world.hpp"
#include "matching/match_scene.hpp"

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
  const KeyScan key(scan, {1.0, 0.0, kPi / 2.0});  // the wall is at y = 2 in the map
  const LikelihoodField& field = key.field();
  for (const double x : {0.02, 0.5, 0.98}) {
    EXPECT_GT(field.likelihood(field.geometry().cell_at({x, 2.0})), 150) << x;
    EXPECT_EQ(field.likelihood(field.geometry().cell_at({x, 1.0})), 0) << x;
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
}

}  // namespace
}  // namespace matchbox_slam
