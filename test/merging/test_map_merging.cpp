#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "merging/map_merging.hpp"
#include "slam/maps_of_rooms.hpp"

namespace matchbox_slam {
namespace {

const MergeProgress kNobody = [](std::size_t, double) {};

const Pose2 kFirst{};
const Pose2 kSecond{7.0, -3.0, 2.0};

/// Largest distance [m] of key scans from where they were taken.
double largest_error(const MergedMap& map, const Pose2& map_from_world, std::uint64_t seed,
                     const std::vector<std::size_t>& begins) {
  const std::vector<Pose2> way = way_through_rooms(seed);
  double largest = 0.0;
  for (const MergedStretch& stretch : map.stretches) {
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      const Pose2 truth = map_from_world * way[begins[stretch.input] + i - stretch.begin];
      const Pose2& pose = map.component.key_scans.all()[i].map_from_base;
      largest = std::max(largest, (pose.translation() - truth.translation()).norm());
    }
  }
  return largest;
}

TEST(MergeMaps, TwoDrivesOfTheSameRoomsBecomeOneMapInTheFrameOfTheFirst) {
  const std::vector<MergedMap> maps =
      merged_maps({map_of_way(3, 0, 60, kFirst), map_of_way(3, 30, 100, kSecond)}, {}, kNobody);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].component.key_scans.size(), 130U);
  EXPECT_EQ(maps[0].loops.nodes, 130U);
  ASSERT_EQ(maps[0].joints.size(), 1U);
  EXPECT_LE(largest_error(maps[0], kFirst, 3, {0, 30}), 0.02);
}

TEST(MergeMaps, TheOrderChangesTheFrameAlone) {
  const EngineState first = map_of_way(3, 0, 60, kFirst);
  const EngineState second = map_of_way(3, 30, 100, kSecond);
  const std::vector<MergedMap> one = merged_maps({first, second}, {}, kNobody);
  const std::vector<MergedMap> other = merged_maps({second, first}, {}, kNobody);
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(other.size(), 1U);
  const PlacedScans& a = one[0].component.key_scans.all();
  const PlacedScans& b = other[0].component.key_scans.all();
  ASSERT_EQ(a.size(), b.size());
  const Pose2 a_from_b = a[0].map_from_base * b[0].map_from_base.inverse();
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].scan->stamp(), b[i].scan->stamp());
    const Eigen::Vector3d off = difference(a_from_b * b[i].map_from_base, a[i].map_from_base);
    EXPECT_LE(off.norm(), 1e-9) << i;
  }
  EXPECT_LE(largest_error(other[0], kSecond, 3, {30, 0}), 0.02);
}

TEST(MergeMaps, TheSameMapsGiveTheSameBits) {
  const std::vector<EngineState> inputs{map_of_way(3, 0, 60, kFirst),
                                        map_of_way(3, 30, 100, kSecond)};
  const std::vector<MergedMap> one = merged_maps(inputs, {}, kNobody);
  const std::vector<MergedMap> again = merged_maps(inputs, {}, kNobody);
  ASSERT_EQ(one[0].component.key_scans.size(), again[0].component.key_scans.size());
  for (std::size_t i = 0; i < one[0].component.key_scans.size(); ++i) {
    const Pose2& a = one[0].component.key_scans.all()[i].map_from_base;
    const Pose2& b = again[0].component.key_scans.all()[i].map_from_base;
    EXPECT_TRUE(a.x == b.x && a.y == b.y && a.theta == b.theta);
  }
}

TEST(MergeMaps, DifferentBuildingsStayApartAsTheyWere) {
  const std::vector<MergedMap> maps =
      merged_maps({map_of_way(4, 0, 25, kSecond), map_of_way(3, 0, 25, kFirst)}, {}, kNobody);
  ASSERT_EQ(maps.size(), 2U);
  EXPECT_EQ(maps[0].stretches.at(0).input, 0U);
  EXPECT_EQ(maps[1].stretches.at(0).input, 1U);
  EXPECT_LE(largest_error(maps[0], kSecond, 4, {0, 0}), 1e-12);
  EXPECT_LE(largest_error(maps[1], kFirst, 3, {0, 0}), 1e-12);
}

TEST(MergeMaps, AComponentIsAMapLikeOthersAndScansThatWaitAreKept) {
  EngineState lost = map_of_way(3, 0, 30, kFirst);
  const EngineState component = map_of_way(3, 10, 50, kSecond);
  const EngineState late = map_of_way(3, 50, 55, kSecond);
  const EngineOptions options;
  lost.localization.components.push_back(
      {SlamMap(options.map, options.field), component.key_scans, {}, 0.0});
  for (const PlacedScan& waiting : late.key_scans.all()) {
    lost.localization.pending.push_back({1, waiting});
  }
  const std::vector<MergedMap> maps = merged_maps({lost}, {}, kNobody);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].component.key_scans.size(), 75U);
  const EngineState saved = state_of(maps[0]);
  EXPECT_EQ(saved.key_scans.size(), 75U);
  EXPECT_EQ(saved.loops.nodes, 75U);
  EXPECT_TRUE(saved.localization.components.empty());
}

}  // namespace
}  // namespace matchbox_slam
