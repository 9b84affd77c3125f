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
MapParts map_and_lost_robot() {
  const SimulatedRun run = perfect_drive();
  const EngineState map = map_of(run);
  std::vector<MapPart> parts(2, MapPart{map.map, map.key_scans, {}, 0.0});
  return MapParts(std::move(parts), 1, {});
}

TEST(Relocalizer, LooksAtOneKeyScanAnInterval) {
  const MapParts parts = map_and_lost_robot();
  EngineOptions options;
  options.recovery.sure = 100.0;  // so that it goes on
  options.recovery.interval = 0.5;
  Relocalizer finder;
  finder.begin(1.0);
  const auto explained_at = [&](double stamp) {
    EXPECT_FALSE(finder.find(stamp, {}, parts, options));
    return finder.search().explained.size();
  };
  EXPECT_FALSE(finder.has_begun(0.9));
  EXPECT_EQ(explained_at(1.2), 0U) << "the next one is early enough";
  EXPECT_EQ(explained_at(1.5), 1U);
  EXPECT_EQ(explained_at(1.9), 1U);
  EXPECT_EQ(explained_at(60.0), 2U) << "no scan waits long";
}

TEST(Relocalizer, LooksAtEachKeyScanOnce) {
  const MapParts parts = map_and_lost_robot();
  EngineOptions options;
  options.recovery.sure = 100.0;
  Relocalizer finder;
  for (int i = 1; i < 60; ++i) {
    static_cast<void>(finder.find(i, {}, parts, options));
  }
  std::set<std::uint64_t> ids;
  for (const ExplainedScan& explained : finder.search().explained) {
    EXPECT_TRUE(ids.insert(explained.key_scan).second);
  }
  EXPECT_EQ(ids.size(), std::min<std::size_t>(40, parts.all()[1].key_scans.size()));
}

/// As a saved map may say, or where what the robot has drawn apart was taken back.
TEST(Relocalizer, ForgetsKeyScansThatAreNoMore) {
  const MapParts parts = map_and_lost_robot();
  PlaceSearch search;
  search.explained = {{std::numeric_limits<std::uint64_t>::max(), 0, {}, 9.0, 0.0}};
  Relocalizer finder(search);
  static_cast<void>(finder.find(1.0, {}, parts, {}));
  ASSERT_EQ(finder.search().explained.size(), 1U);
  EXPECT_LT(finder.search().explained[0].key_scan, parts.all()[1].key_scans.size());
}

}  // namespace
}  // namespace matchbox_slam
