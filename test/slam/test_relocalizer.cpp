#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "simulation/simulation_support.hpp"
#include "slam/lost_robot.hpp"
#include "slam/relocalizer.hpp"

namespace matchbox_slam {
namespace {

/// A map, and beside it that of a robot which has driven through it and is lost.
MapComponents map_and_lost_robot() {
  const SimulatedRun run = perfect_drive();
  const EngineState map = map_of(run);
  std::vector<MapComponent> components(2, MapComponent{map.map, map.key_scans, {}, 0.0});
  return MapComponents(std::move(components), 1, {});
}

TEST(Relocalizer, LooksAtOneKeyScanAnInterval) {
  const MapComponents components = map_and_lost_robot();
  EngineOptions options;
  options.recovery.sure = 100.0;  // so that it goes on
  options.recovery.interval = 0.5;
  Relocalizer finder;
  finder.begin(1.0);
  const auto explained_at = [&](double stamp) {
    EXPECT_FALSE(finder.find(stamp, {}, components, options));
    return finder.search().explained.size();
  };
  EXPECT_FALSE(finder.has_begun(0.9));
  EXPECT_EQ(explained_at(1.2), 0U) << "the next one is early enough";
  EXPECT_EQ(explained_at(1.5), 1U);
  EXPECT_EQ(explained_at(1.9), 1U);
  EXPECT_EQ(explained_at(60.0), 2U) << "no scan waits long";
}

TEST(Relocalizer, LooksAtEachKeyScanOnce) {
  const MapComponents components = map_and_lost_robot();
  EngineOptions options;
  options.recovery.sure = 100.0;
  Relocalizer finder;
  for (int i = 1; i < 60; ++i) {
    static_cast<void>(finder.find(i, {}, components, options));
  }
  std::set<std::uint64_t> ids;
  for (const ExplainedScan& explained : finder.search().explained) {
    EXPECT_TRUE(ids.insert(explained.key_scan).second);
  }
  EXPECT_EQ(ids.size(), std::min<std::size_t>(40, components.all()[1].key_scans.size()));
}

/// A map of many key scans, all of them of one drive, and a robot that drives it again.
MapComponents large_map_and_lost_robot() {
  const SimulatedRun run = perfect_drive();
  const EngineState map = map_of(run);
  MapComponent large{map.map, {}, {}, 0.0};
  while (large.key_scans.size() < 600) {
    for (const PlacedScan& key : map.key_scans.all()) {
      large.key_scans.add(key);
    }
  }
  std::vector<MapComponent> components{large, MapComponent{map.map, map.key_scans, {}, 0.0}};
  return MapComponents(std::move(components), 1, {});
}

bool is_same(const PlaceSearch& a, const PlaceSearch& b) {
  const auto is_same_place = [](const PlaceHypothesis& one, const PlaceHypothesis& other) {
    return one.component == other.component &&
           one.component_from_active == other.component_from_active &&
           one.log_odds == other.log_odds && one.behind == other.behind;
  };
  return a.stamp == b.stamp && a.indexed == b.indexed && a.sampled == b.sampled &&
         a.alike == b.alike && a.explained.size() == b.explained.size() &&
         std::equal(a.hypotheses.begin(), a.hypotheses.end(), b.hypotheses.begin(),
                    b.hypotheses.end(), is_same_place);
}

/// A few key scans with each scan; a place that was not looked at yet counts as none.
TEST(Relocalizer, SearchesNothingBeforeItKnowsAllPlaces) {
  const MapComponents components = large_map_and_lost_robot();
  EngineOptions options;
  options.recovery.sure = 100.0;
  Relocalizer finder;
  finder.begin(1.0);
  std::vector<std::uint64_t> indexed;
  for (int i = 1; finder.search().explained.empty() && i < 100; ++i) {
    EXPECT_TRUE(finder.search().hypotheses.empty());
    EXPECT_EQ(finder.search().sampled, 0);
    static_cast<void>(finder.find(1.0 + i, {}, components, options));
    indexed.push_back(finder.search().indexed);
  }
  const std::uint64_t all = components.map().key_scans.size();
  EXPECT_EQ(indexed, (std::vector<std::uint64_t>{256, 512, all}));
  EXPECT_FALSE(finder.search().hypotheses.empty());
}

TEST(Relocalizer, GoesOnFromWhereItWas) {
  const MapComponents components = large_map_and_lost_robot();
  EngineOptions options;
  options.recovery.sure = 100.0;
  Relocalizer finder;
  for (int i = 1; i < 9; ++i) {
    Relocalizer saved(finder.search(), components);
    static_cast<void>(finder.find(i, {}, components, options));
    static_cast<void>(saved.find(i, {}, components, options));
    EXPECT_TRUE(is_same(saved.search(), finder.search())) << "saved before scan " << i;
  }
}

/// As a saved map may say, or where what the robot has drawn in its component was taken back.
TEST(Relocalizer, ForgetsKeyScansThatAreNoMore) {
  const MapComponents components = map_and_lost_robot();
  PlaceSearch search;
  search.explained = {{std::numeric_limits<std::uint64_t>::max(), 0, {}, 9.0, 0.0}};
  search.indexed = components.map().key_scans.size();
  Relocalizer finder(search, components);
  static_cast<void>(finder.find(1.0, {}, components, {}));
  ASSERT_EQ(finder.search().explained.size(), 1U);
  EXPECT_LT(finder.search().explained[0].key_scan, components.all()[1].key_scans.size());
}

}  // namespace
}  // namespace matchbox_slam
