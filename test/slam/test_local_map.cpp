#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "matching/rendered_map.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/local_map.hpp"
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
  EXPECT_TRUE(same_map(rendered(keys, kMap, kField, MapUse::kShown), inserted(keys)));
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
  const LocalScans all = local_scans_where(keys, std::vector<bool>(6, false));
  EXPECT_TRUE(all.apart.empty());
  EXPECT_EQ(all.newest, 5U);
  EXPECT_EQ(all.center, keys.back().map_from_base.translation());
  EXPECT_EQ(stamps(all.belonging), stamps(keys));
  const LocalScans some = local_scans_where(keys, {true, false, true, false, false, false});
  EXPECT_EQ(some.apart, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(stamps(some.belonging), stamps({keys[1], keys[3], keys[4], keys[5]}));
}

TEST(LocalScans, AreNoFartherThanTheRobotSees) {
  PlacedScans keys = drive_through_rooms(4);
  const Pose2& newest = keys.back().map_from_base;
  keys[0].map_from_base = Pose2{newest.x + 14.9, newest.y, 0.0};
  keys[1].map_from_base = Pose2{newest.x, newest.y - 25.1, 0.0};
  EXPECT_TRUE(local_scans_where(keys, {false, true, false, false}).apart.empty());
  keys[1].map_from_base = Pose2{newest.x, newest.y - 24.9, 0.0};
  EXPECT_EQ(local_scans_where(keys, {false, true, false, false}).apart,
            std::vector<std::uint64_t>{1})
      << "it will be soon";
  EXPECT_EQ(stamps(local_scans_where(keys, {false, false, true, false}).belonging),
            stamps({keys[0], keys[3]}));
}

/// Of 150 that are near, all of which belong there.
void expect_last_100_drawn(const PlacedScans& keys) {
  const LocalScans scans = local_scans_where(keys, std::vector<bool>(150, false));
  EXPECT_EQ(scans.belonging.size(), 150U);
  const LocalMap near(scans, kMap, kField);
  ASSERT_EQ(near.drawn().size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(near.drawn()[i], keys[50 + i].scan->id()) << i;
  }
  EXPECT_TRUE(same_map(*near.map(), inserted({keys.begin() + 50, keys.end()})));
}

TEST(LocalMap, ShowsTheNearestOfMany) {
  const PlacedScans few = drive_through_rooms(6);
  PlacedScans keys;
  for (std::size_t i = 0; i < 150; ++i) {  // from 7.45 m to 0
    keys.push_back({few[i % 6].scan, {0.05 * static_cast<double>(149 - i), 0.0, 0.0}});
  }
  expect_last_100_drawn(keys);
}

/// As where the robot turns, or stands and is seen anew.
TEST(LocalMap, ShowsTheNewestOfManyThatAreEquallyNear) {
  const PlacedScans few = drive_through_rooms(6);
  PlacedScans keys;
  for (std::size_t i = 0; i < 150; ++i) {
    keys.push_back({few[i % 6].scan, {1.0, 2.0, 0.01 * static_cast<double>(i)}});
  }
  expect_last_100_drawn(keys);
}

TEST(LocalMap, TakesInWhatCameSince) {
  PlacedScans keys = drive_through_rooms(6);
  const PlacedScans first(keys.begin(), keys.begin() + 3);
  LocalMap near(local_scans_where(first, {true, false, false}), kMap, kField);
  keys[4].map_from_base.x += 40.0;  // mapped elsewhere
  near.take_new(keys, kMap);
  ASSERT_NE(near.map(), nullptr);
  EXPECT_TRUE(same_map(*near.map(), inserted({keys[1], keys[2], keys[3], keys[5]})));
  near.take_new(keys, kMap);
  EXPECT_TRUE(same_map(*near.map(), inserted({keys[1], keys[2], keys[3], keys[5]})));
  near.clear();
  EXPECT_EQ(near.map(), nullptr);
}

TEST(LocalMap, IsGoneOnWithByWhatHasComeNear) {
  KeyScans all;
  for (const PlacedScan& key : drive_through_rooms(6)) {
    all.add(key);
  }
  const PlacedScans& keys = all.all();
  const PlacedScans first(keys.begin(), keys.begin() + 4);
  LocalMap before(local_scans_where(first, {true, true, false, false}), kMap, kField);
  before.take_new({keys.begin(), keys.begin() + 5}, kMap);
  const auto near = [&](bool is_older_apart) {
    return local_scans_where(keys, {true, is_older_apart, false, false, false, false});
  };
  const std::optional<LocalMap> more = before.with(near(true), kMap);
  ASSERT_TRUE(more);
  EXPECT_EQ(more->drawn(), (std::vector<std::uint64_t>{2, 3, 4, 5}));
  EXPECT_EQ(more->center(), keys.back().map_from_base.translation());
  EXPECT_TRUE(same_map(*more->map(), inserted({keys[2], keys[3], keys[4], keys[5]})));
  EXPECT_TRUE(same_map(*before.map(), inserted({keys[2], keys[3], keys[4]}))) << "a copy";
  EXPECT_TRUE(same_map(*more->as_of(4, keys, kMap, kField).map(), inserted({keys[2], keys[3]})));
  const LocalMap again(more->center(), {keys[2], keys[3], keys[4], keys[5]}, 6, kMap, kField);
  EXPECT_TRUE(same_map(*again.map(), *more->map()));
  EXPECT_EQ(again.drawn(), more->drawn());
  EXPECT_FALSE(before.with(near(false), kMap)) << "what is older would be drawn as the newest";
}

TEST(LocalMap, IsMadeAnewWhereItShowsWhatLiesApart) {
  KeyScans all;
  for (const PlacedScan& key : drive_through_rooms(3)) {
    all.add(key);
  }
  const PlacedScans& keys = all.all();
  const LocalMap before(local_scans_where({keys[0], keys[1]}, {false, false}), kMap, kField);
  const auto near = [&](const std::vector<bool>& is_apart) {
    return local_scans_where(keys, is_apart);
  };
  EXPECT_TRUE(before.with(near({false, false, false}), kMap));
  EXPECT_FALSE(before.with(near({false, true, false}), kMap));
  EXPECT_FALSE(LocalMap().with(near({false, false, false}), kMap)) << "there is none";
  EXPECT_FALSE(LocalMap().as_of(2, keys, kMap, kField).map());
}

TEST(LocalMap, IsMadeAnewWhenItShowsTooMany) {
  PlacedScans keys(260, drive_through_rooms(1).front());
  KeyScans all;
  for (const PlacedScan& key : keys) {
    all.add(key);
  }
  keys = all.all();
  const auto near_with = [&](std::size_t shown) {
    const PlacedScans first(keys.begin(), keys.begin() + 1);
    LocalMap map(local_scans_where(first, {false}), kMap, kField);
    map.take_new({keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(shown)}, kMap);
    const LocalScans near = local_scans_where(keys, std::vector<bool>(260, false));
    return map.with(near, kMap).has_value();
  };
  EXPECT_TRUE(near_with(150)) << "with the 100 nearest";
  EXPECT_FALSE(near_with(250));
}

TEST(LocalMap, GoesOnWhereKeyScansThatItDoesNotShowAreTakenOut) {
  KeyScans keys;
  for (const PlacedScan& key : drive_through_rooms(6)) {
    keys.add(key);
  }
  PlacedScans first = keys.all();
  first.resize(5);
  const LocalScans scans = without(local_scans_where(first, std::vector<bool>(5, false)), {1, 3});
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
  const LocalMap near(local_scans_where(keys, {false, false}), kMap, kField);
  EXPECT_FALSE(near.is_due(keys));
  keys.back().map_from_base.y += 4.9;
  EXPECT_FALSE(near.is_due(keys));
  keys.back().map_from_base.y += 0.2;
  EXPECT_TRUE(near.is_due(keys));
}

}  // namespace
}  // namespace matchbox_slam
