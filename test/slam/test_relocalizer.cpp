#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/lost_robot.hpp"
#include "slam/relocalizer.hpp"

namespace matchbox_slam {
namespace {

/// Key scans that are searched with one scan, so long and so far after the one searched before.
std::size_t searched_after(const SearchStep& step, const RecoveryOptions& recovery = {}) {
  static const SimulatedRun run = perfect_drive();
  static const EngineState map = map_of(run);
  EngineOptions options;
  options.recovery = recovery;
  const MapParts parts(
      {{map.map, map.key_scans, {}, 0.0}, {SlamMap(options.map, options.field), {}, {}, 0.0}}, 1,
      {});
  PointScan scan = project_scan(run.scans.front(), run.base_from_laser, {}, options.scan);
  PlaceSearch search;
  search.stamp = scan.stamp;
  scan.stamp += step.seconds;
  Relocalizer finder(search, parts);
  EXPECT_FALSE(finder.find(scan, {}, step, parts, options));
  return finder.search().next;
}

TEST(Relocalizer, SearchesAsManyKeyScansForASecondOrAMetreHoweverManyScansThereAreOfIt) {
  EXPECT_EQ(searched_after({0.05, 0.02}), 0U) << "the next one is early enough";
  EXPECT_EQ(searched_after({0.1, 0.05}), 1U);
  EXPECT_EQ(searched_after({0.25, 0.05}), 2U);
  EXPECT_EQ(searched_after({0.1, 0.25}), 2U);
  EXPECT_EQ(searched_after({0.01, 0.35}), 3U) << "stamps may be made up";
  EXPECT_EQ(searched_after({60.0, 30.0}), 5U) << "no scan waits long";
  EXPECT_EQ(searched_after({0.1, 30.0}), 5U);
  RecoveryOptions options;
  options.key_scans = 2;
  options.interval = 0.5;
  EXPECT_EQ(searched_after({0.3, 0.0}, options), 0U);
  EXPECT_EQ(searched_after({0.5, 0.0}, options), 2U);
  EXPECT_EQ(searched_after({1.0, 0.0}, options), 4U);
  EXPECT_EQ(searched_after({5.0, 0.0}, options), 10U);
  options.interval = 0.0;
  EXPECT_EQ(searched_after({0.01, 0.0}, options), 2U) << "as often as there are scans";
}

}  // namespace
}  // namespace matchbox_slam
