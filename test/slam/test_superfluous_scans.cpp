#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/slam/key_scans.hpp"
#include "matching/rendered_map.hpp"
#include "simulation/simulation_support.hpp"
#include "simulation/world.hpp"
#include "slam/local_map.hpp"
#include "slam/superfluous_scans.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kEnough = 9;
constexpr std::size_t kOfPass = 21;  // key scans, 0.3 m apart

void add_wall(double x, double y, double to_x, double to_y, std::vector<WallSegment>& walls) {
  WallSegment wall;
  wall.start = {x, y};
  wall.end = {to_x, to_y};
  walls.push_back(wall);
}

/// A hall of 10 x 4 m with an alcove of 3 x 2 m behind a door that may be shut.
World hall(bool is_open, const std::vector<WallSegment>& more = {}) {
  std::vector<WallSegment> walls = more;
  add_wall(-1.0, -2.0, 9.0, -2.0, walls);
  add_wall(9.0, -2.0, 9.0, 2.0, walls);
  add_wall(9.0, 2.0, 4.6, 2.0, walls);
  add_wall(3.4, 2.0, -1.0, 2.0, walls);
  add_wall(-1.0, 2.0, -1.0, -2.0, walls);
  add_wall(3.0, 2.0, 3.0, 4.0, walls);
  add_wall(3.0, 4.0, 6.0, 4.0, walls);
  add_wall(6.0, 4.0, 6.0, 2.0, walls);
  if (!is_open) {
    add_wall(3.4, 2.0, 4.6, 2.0, walls);
  }
  return {walls, {}};
}

/// Drives through the hall, from the one end to the other.
void map_through(const World& world, KeyScans& keys, double field_of_view = 2.0 * kPi) {
  LaserOptions laser;
  laser.beams = 360;
  laser.field_of_view = field_of_view;
  laser.mount_x = 0.0;
  const std::size_t pass = keys.size() / kOfPass;
  for (std::size_t i = 0; i < kOfPass; ++i) {
    const Pose2 pose{0.3 * static_cast<double>(i) + 0.02 * static_cast<double>(pass % 5),
                     0.03 * static_cast<double>(pass % 3), 0.0};
    keys.add(MeasuredScan{ideal_scan(world, laser, pose), laser.base_from_laser(), {}, {}}, 0,
             pose);
  }
}

std::vector<std::uint64_t> superfluous(const KeyScans& keys) {
  return superfluous_scans(keys.all(), keys.size() - 1, kEnough);
}

/// Takes out what is superfluous; returns how many.
std::size_t tidy(KeyScans& keys) {
  const std::vector<std::uint64_t> ids = superfluous(keys);
  std::vector<bool> is_taken(keys.size(), false);
  for (const std::uint64_t id : ids) {
    is_taken.at(id) = true;
  }
  keys.take_out(is_taken);
  return ids.size();
}

TEST(SuperfluousScans, AreNoneOfWhatWasSeenOnceOrTwice) {
  KeyScans keys;
  for (int pass = 0; pass < 2; ++pass) {
    map_through(hall(true), keys);
    EXPECT_TRUE(superfluous(keys).empty());
  }
  EXPECT_FALSE(is_crowded(keys.all(), kEnough));
}

TEST(SuperfluousScans, AreNoneOfARobotThatTurnsRound) {
  KeyScans keys;
  const World world = hall(true);
  LaserOptions laser;
  for (int i = 0; i < 32; ++i) {
    const Pose2 pose{3.0, 0.0, wrap_angle(0.2 * i)};
    keys.add(MeasuredScan{ideal_scan(world, laser, pose), laser.base_from_laser(), {}, {}}, 0,
             pose);
  }
  EXPECT_TRUE(superfluous_scans(keys.all(), 1000, kEnough).empty());
}

TEST(SuperfluousScans, LeaveAsManyHoweverOftenAPlaceIsSeen) {
  KeyScans keys;
  std::vector<std::size_t> sizes;
  for (int pass = 0; pass < 30; ++pass) {
    map_through(hall(true), keys);
    static_cast<void>(tidy(keys));
    sizes.push_back(keys.size());
  }
  EXPECT_LE(sizes.back(), 6 * kOfPass);
  EXPECT_LE(*std::max_element(sizes.begin() + 10, sizes.end()),
            *std::min_element(sizes.begin() + 8, sizes.begin() + 12) + 2);
  for (std::size_t id = 0; id < keys.size(); ++id) {
    EXPECT_EQ(keys.all()[id].scan->id(), id);
  }
}

/// So that a map that is renewed over and over does not wander.
TEST(SuperfluousScans, LeaveTheOldestOfEachPlaceAsLongAsItIsRight) {
  KeyScans keys;
  map_through(hall(true), keys);
  std::vector<Pose2> before;
  for (const PlacedScan& key : keys.all()) {
    before.push_back(key.map_from_base);
  }
  for (int pass = 0; pass < 12; ++pass) {
    map_through(hall(true), keys);
    static_cast<void>(tidy(keys));
  }
  std::vector<double> left;
  for (const PlacedScan& key : keys.all()) {
    if (std::find(before.begin(), before.end(), key.map_from_base) != before.end() &&
        left.size() < kOfPass && (left.empty() || key.map_from_base.x > left.back())) {
      left.push_back(key.map_from_base.x);
    }
  }
  ASSERT_GE(left.size(), 10U);
  for (std::size_t i = 1; i < left.size(); ++i) {
    EXPECT_LE(left[i] - left[i - 1], 0.91);
  }
}

TEST(SuperfluousScans, AreTheOldestToo_WhereTheyAreWrongByNow) {
  std::vector<WallSegment> shelf;
  add_wall(-1.0, -0.8, 9.0, -0.8, shelf);
  KeyScans keys;
  for (int pass = 0; pass < 3; ++pass) {
    map_through(hall(true, shelf), keys);
  }
  const std::size_t before = keys.size();
  for (int pass = 0; pass < 8; ++pass) {
    map_through(hall(true), keys);
  }
  const std::vector<std::uint64_t> ids = superfluous(keys);
  std::size_t old = 0;
  for (const std::uint64_t id : ids) {
    old += id < before ? 1 : 0;
  }
  EXPECT_GE(old, before - 4) << "the first of all and those of the ends may stay";
}

/// What is behind a door that is shut by now only the old key scans have seen.
TEST(SuperfluousScans, KeepWhatNobodyElseSaw) {
  KeyScans keys;
  map_through(hall(true), keys);
  for (int pass = 0; pass < 12; ++pass) {
    map_through(hall(false), keys);
    static_cast<void>(tidy(keys));
  }
  EXPECT_LE(keys.size(), 7 * kOfPass);
  const SlamMap map = rendered(keys.all(), {}, {}, MapUse::kShown);
  std::size_t walls = 0;
  for (double x = 3.3; x < 5.6; x += 0.1) {
    const Cell cell = map.field.geometry().cell_at(Eigen::Vector2d(x, 4.0));
    walls += map.field.likelihood(cell) > 0 ? 1 : 0;
  }
  EXPECT_GE(walls, 20U);
}

/// The shelf ends behind the last key scan: only the first drive saw it from there, where those
/// that came since look ahead alone.
TEST(SuperfluousScans, KeepWhatOthersLookedAwayFrom) {
  std::vector<WallSegment> shelf;
  add_wall(-1.0, -0.8, 9.0, -0.8, shelf);
  const auto is_last_superfluous = [&](double field_of_view) {
    KeyScans keys;
    map_through(hall(true, shelf), keys);
    for (int pass = 0; pass < 8; ++pass) {
      map_through(hall(true), keys, field_of_view);
    }
    const std::vector<std::uint64_t> ids = superfluous(keys);
    return std::find(ids.begin(), ids.end(), kOfPass - 1) != ids.end();
  };
  EXPECT_TRUE(is_last_superfluous(2.0 * kPi));
  EXPECT_FALSE(is_last_superfluous(kPi));
}

TEST(SuperfluousScans, AreTheSameHoweverTheMapLies) {
  KeyScans keys;
  for (int pass = 0; pass < 8; ++pass) {
    map_through(hall(true), keys);
  }
  PlacedScans turned = keys.all();
  for (PlacedScan& key : turned) {
    key.map_from_base = Pose2{-7.0, 3.0, 0.5 * kPi} * key.map_from_base;
  }
  const std::vector<std::uint64_t> ids = superfluous(keys);
  EXPECT_GT(ids.size(), 20U);
  EXPECT_EQ(superfluous_scans(turned, turned.size() - 1, kEnough), ids);
}

TEST(SuperfluousScans, AreLookedForWhereThereAreMany) {
  KeyScans keys;
  for (int pass = 0; pass < 6; ++pass) {
    map_through(hall(true), keys);
  }
  PlacedScans all = keys.all();
  all.resize(all.size() - kOfPass / 2);
  EXPECT_TRUE(is_crowded(all, kEnough));
  EXPECT_FALSE(is_crowded(all, 0));
  EXPECT_FALSE(is_crowded(all, 40));
}

}  // namespace
}  // namespace matchbox_slam
