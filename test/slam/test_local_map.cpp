#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "matchbox_slam/slam/local_map.hpp"
#include "matching/rendered_map.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/local_scans.hpp"
#include "slam/map_equality.hpp"

namespace matchbox_slam {
namespace {

const MapOptions kMap;
const LikelihoodFieldOptions kField;

SlamMap inserted(const PlacedScans& keys) {
  SlamMap map(kMap, kField);
  for (const PlacedScan& key : keys) {
    insert_scan(*key.scan->points(), key.map_from_base, kMap, map);
  }
  return map;
}

TEST(LocalMap, WhatIsRenderedIsAsInserted) {
  const PlacedScans keys = drive_through_rooms(6);
  EXPECT_TRUE(same_map(rendered(keys, kMap, kField), inserted(keys)));
}

AreWeaklyConnected of(const std::vector<bool>& is_apart) {
  return [is_apart](const std::vector<std::size_t>& keys) {
    std::vector<bool> asked;
    for (const std::size_t key : keys) {
      asked.push_back(is_apart.at(key));
    }
    return asked;
  };
}

std::vector<double> stamps(const PlacedScans& keys) {
  std::vector<double> stamps;
  for (const PlacedScan& key : keys) {
    stamps.push_back(key.scan->stamp());
  }
  return stamps;
}

TEST(LocalScans, AreThoseThatBelong) {
  const PlacedScans keys = drive_through_rooms(6);
  const LocalScans all = local_scans(keys, of(std::vector<bool>(6, false)));
  EXPECT_FALSE(all.is_any_apart);
  EXPECT_EQ(all.newest, 5U);
  EXPECT_EQ(all.center, keys.back().map_from_base.translation());
  EXPECT_EQ(stamps(all.belonging), stamps(keys));
  const LocalScans some = local_scans(keys, of({true, false, true, false, false, false}));
  EXPECT_TRUE(some.is_any_apart);
  EXPECT_EQ(stamps(some.belonging), stamps({keys[1], keys[3], keys[4], keys[5]}));
}

TEST(LocalScans, AreNoFartherThanTheRobotSees) {
  PlacedScans keys = drive_through_rooms(4);
  const Pose2& newest = keys.back().map_from_base;
  keys[0].map_from_base = Pose2{newest.x + 14.9, newest.y, 0.0};
  keys[1].map_from_base = Pose2{newest.x, newest.y - 25.1, 0.0};
  EXPECT_FALSE(local_scans(keys, of({false, true, false, false})).is_any_apart);
  keys[1].map_from_base = Pose2{newest.x, newest.y - 24.9, 0.0};
  EXPECT_TRUE(local_scans(keys, of({false, true, false, false})).is_any_apart) << "it will be soon";
  EXPECT_EQ(stamps(local_scans(keys, of({false, false, true, false})).belonging),
            stamps({keys[0], keys[3]}));
}

TEST(LocalScans, AreTheNearestOfMany) {
  const PlacedScans few = drive_through_rooms(6);
  PlacedScans keys;
  for (std::size_t i = 0; i < 150; ++i) {  // from 7.45 m to 0
    keys.push_back({few[i % 6].scan, {0.05 * static_cast<double>(149 - i), 0.0, 0.0}});
  }
  const PlacedScans near = local_scans(keys, of(std::vector<bool>(150, false))).belonging;
  ASSERT_EQ(near.size(), 100U);
  EXPECT_EQ(near.front().map_from_base, keys[50].map_from_base);
  EXPECT_EQ(near.back().map_from_base, keys.back().map_from_base);
}

/// As where the robot turns, or stands and is seen anew.
TEST(LocalScans, AreTheNewestOfManyThatAreEquallyNear) {
  const PlacedScans few = drive_through_rooms(6);
  PlacedScans keys;
  for (std::size_t i = 0; i < 150; ++i) {
    keys.push_back({few[i % 6].scan, {1.0, 2.0, 0.01 * static_cast<double>(i)}});
  }
  const PlacedScans near = local_scans(keys, of(std::vector<bool>(150, false))).belonging;
  ASSERT_EQ(near.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(near[i].map_from_base, keys[50 + i].map_from_base) << i;
  }
}

TEST(LocalMap, TakesInWhatCameSince) {
  PlacedScans keys = drive_through_rooms(6);
  const PlacedScans first(keys.begin(), keys.begin() + 3);
  LocalMap near(local_scans(first, of({true, false, false})), kMap, kField);
  keys[4].map_from_base.x += 40.0;  // mapped elsewhere
  near.take_new(keys, kMap);
  ASSERT_NE(near.map(), nullptr);
  EXPECT_TRUE(same_map(*near.map(), inserted({keys[1], keys[2], keys[3], keys[5]})));
  near.take_new(keys, kMap);
  EXPECT_TRUE(same_map(*near.map(), inserted({keys[1], keys[2], keys[3], keys[5]})));
  near.clear();
  EXPECT_EQ(near.map(), nullptr);
}

TEST(LocalMap, GoesOnWhereKeyScansThatItDoesNotShowAreTakenOut) {
  KeyScans keys;
  for (const PlacedScan& key : drive_through_rooms(6)) {
    keys.add(key);
  }
  PlacedScans first = keys.all();
  first.resize(5);
  const LocalScans scans = without(local_scans(first, of(std::vector<bool>(5, false))), {1, 3});
  std::vector<std::uint64_t> ids;
  for (const PlacedScan& key : scans.belonging) {
    ids.push_back(key.scan->id());
  }
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{0, 2, 4}));
  LocalMap near(scans, kMap, kField);
  keys.take_out({false, true, false, true, false, false});
  near.renumber({0, 0, 1, 1, 2, 3}, 2);
  EXPECT_EQ(near.drawn(), (std::vector<std::uint64_t>{0, 1, 2}));
  near.take_new(keys.all(), kMap);
  EXPECT_EQ(near.drawn(), (std::vector<std::uint64_t>{0, 1, 2, 3}));
  EXPECT_TRUE(same_map(*near.map(), inserted(keys.all())));
}

TEST(LocalMap, IsDueWhenThereIsNoneOrTheRobotHasMoved) {
  PlacedScans keys = drive_through_rooms(2);
  EXPECT_TRUE(LocalMap().is_due(keys));
  const LocalMap near(local_scans(keys, of({false, false})), kMap, kField);
  EXPECT_FALSE(near.is_due(keys));
  keys.back().map_from_base.y += 4.9;
  EXPECT_FALSE(near.is_due(keys));
  keys.back().map_from_base.y += 0.2;
  EXPECT_TRUE(near.is_due(keys));
}

}  // namespace
}  // namespace matchbox_slam
