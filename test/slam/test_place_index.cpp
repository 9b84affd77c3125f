#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/lost_robot.hpp"
#include "slam/place_index.hpp"

namespace matchbox_slam {
namespace {

/// The map of a drive, and beside it an empty one.
std::vector<MapComponent> components_of(const SimulatedRun& run) {
  const EngineOptions options;
  const EngineState map = map_of(run);
  return {{map.map, map.key_scans, {}, 0.0}, {SlamMap(options.map, options.field), {}, {}, 0.0}};
}

PointScan seen_from(const Pose2& place, const LaserOptions& laser) {
  return project_scan(ideal_scan(make_world("rooms", 3), laser, place), laser.base_from_laser(), {},
                      EngineOptions{}.scan);
}

bool is_there(const LikelyPlace& likely, const Pose2& place) {
  return (likely.component_from_base.translation() - place.translation()).norm() < 1.0 &&
         std::abs(wrap_angle(likely.component_from_base.theta - place.theta)) < 0.2;
}

/// How many places of the drive, each in a heading of its own, are the most alike of all.
int told(const PlaceIndex& index, const SimulatedRun& run, const LaserOptions& laser,
         std::size_t most) {
  int told = 0;
  for (int i = 0; i < 10; ++i) {
    Pose2 place = run.world_from_base[14 * static_cast<std::size_t>(i)];
    place = {place.x + 0.2, place.y - 0.15, wrap_angle(2.0 * i)};
    bool is_told = false;
    for (const LikelyPlace& likely : index.look_up(seen_from(place, laser), most)) {
      is_told = is_told || is_there(likely, place);
    }
    told += is_told ? 1 : 0;
  }
  return told;
}

TEST(PlaceIndex, TellsWhereAScanWasTakenInAnyHeading) {
  const SimulatedRun run = perfect_drive();
  const PlaceIndex index(components_of(run), 1);
  LaserOptions laser;
  EXPECT_EQ(told(index, run, laser, 96), 10) << "as many as a search looks at";
  EXPECT_GE(told(index, run, laser, 3), 7);
  laser.field_of_view = 2.1;
  laser.beams = 240;
  EXPECT_GE(told(index, run, laser, 96), 8) << "by the part of the circle that it sees";
}

TEST(PlaceIndex, LeavesOutWhatIsKnownAndWhatIsNearABetterOne) {
  const SimulatedRun run = perfect_drive();
  const PlaceIndex index(components_of(run), 1);
  const PointScan scan = seen_from(run.world_from_base[70], {});
  const std::vector<LikelyPlace> all = index.look_up(scan, 20);
  ASSERT_EQ(all.size(), 20U);
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_GE(all[i].unlike, all[i - 1].unlike);
    for (std::size_t k = 0; k < i; ++k) {
      const Pose2 apart = all[k].component_from_base.inverse() * all[i].component_from_base;
      EXPECT_TRUE(apart.translation().norm() > 0.999 || std::abs(apart.theta) >= 0.35);
    }
  }
  for (const LikelyPlace& other : index.look_up(scan, 20, {all.front()})) {
    EXPECT_FALSE(is_there(other, all.front().component_from_base));
  }
}

void expect_same(const std::vector<LikelyPlace>& places, const std::vector<LikelyPlace>& wanted) {
  ASSERT_EQ(places.size(), wanted.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(places[i].component_from_base, wanted[i].component_from_base) << i;
    EXPECT_EQ(places[i].unlike, wanted[i].unlike) << i;
  }
}

TEST(PlaceIndex, IsTheSameInHoweverManyStepsItIsMade) {
  const SimulatedRun run = perfect_drive();
  const std::vector<MapComponent> components = components_of(run);
  const PointScan scan = seen_from(run.world_from_base[70], {});
  const std::vector<LikelyPlace> at_once = PlaceIndex(components, 1).look_up(scan, 200);
  for (const std::size_t each : {1U, 7U, 1000U}) {
    PlaceIndex index;
    std::size_t steps = 1;
    for (; !index.grow(components, 1, each); ++steps) {
      EXPECT_FALSE(index.is_complete());
      EXPECT_EQ(index.key_scans(), steps * each);
    }
    EXPECT_EQ(steps, (components[0].key_scans.size() + each - 1) / each);
    EXPECT_EQ(index.key_scans(), components[0].key_scans.size());
    expect_same(index.look_up(scan, 200), at_once);
  }
}

TEST(PlaceIndex, DoesNotDependOnTheOrderOfTheKeyScans) {
  const SimulatedRun run = perfect_drive();
  const std::vector<MapComponent> components = components_of(run);
  std::vector<MapComponent> reversed = components;
  reversed[0].key_scans = {};
  const PlacedScans& keys = components[0].key_scans.all();
  std::for_each(keys.rbegin(), keys.rend(),
                [&](const PlacedScan& key) { reversed[0].key_scans.add(key); });
  const PointScan scan = seen_from(run.world_from_base[70], {});
  expect_same(PlaceIndex(reversed, 1).look_up(scan, 200),
              PlaceIndex(components, 1).look_up(scan, 200));
}

TEST(PlaceIndex, HasNoPlacesOfTheComponentThatTheRobotMakes) {
  const SimulatedRun run = perfect_drive();
  std::vector<MapComponent> components = components_of(run);
  EXPECT_TRUE(PlaceIndex(components, 0).look_up(seen_from({}, {}), 5).empty());
  EXPECT_TRUE(PlaceIndex(components, 1).look_up(PointScan{}, 5).empty()) << "of a scan of nothing";
  std::swap(components[0], components[1]);
  EXPECT_EQ(
      PlaceIndex(components, 0).look_up(seen_from(run.world_from_base[70], {}), 1)[0].component,
      1U);
}

}  // namespace
}  // namespace matchbox_slam
