#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/near_map.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/map_equality.hpp"

namespace matchbox_slam {
namespace {

const MapOptions kMap;
const LikelihoodFieldOptions kField;

/// Key scans a metre apart through rooms.
PlacedScans drive_through_rooms(std::size_t scans) {
  LaserOptions laser;
  laser.beams = 90;
  const World world = make_rooms_world(3);
  const RobotMotion motion = drive(world.route(), {});
  KeyScans keys;
  for (std::size_t i = 0; i < scans; ++i) {
    const Pose2 pose = motion.pose(4.0 + 2.0 * static_cast<double>(i));
    keys.add(MeasuredScan{ideal_scan(world, laser, pose), laser.base_from_laser(), {}, {}}, 0,
             pose);
  }
  return keys.all();
}

SlamMap inserted(const PlacedScans& keys) {
  SlamMap map(kMap, kField);
  for (const PlacedScan& key : keys) {
    insert_scan(*key.scan->points(), key.map_from_base, kMap, map);
  }
  return map;
}

void add(const PlacedScans& keys, const std::vector<bool>& is_apart, bool is_outdated,
         NearMap& near) {
  near.add(keys, is_apart, is_outdated, kMap, kField);
}

TEST(NearMap, WhatIsRenderedIsAsInserted) {
  const PlacedScans keys = drive_through_rooms(6);
  EXPECT_TRUE(same_map(rendered(keys, kMap, kField), inserted(keys)));
}

TEST(NearMap, IsNoneWhileAllBelongsTogether) {
  const PlacedScans keys = drive_through_rooms(6);
  NearMap near;
  EXPECT_EQ(near.map(), nullptr);
  add(keys, std::vector<bool>(6, false), false, near);
  EXPECT_EQ(near.map(), nullptr);
  add(keys, std::vector<bool>(6, false), true, near);
  ASSERT_NE(near.map(), nullptr) << "the whole map is outdated";
  EXPECT_TRUE(same_map(*near.map(), inserted(keys)));
  add(keys, std::vector<bool>(6, false), false, near);
  EXPECT_EQ(near.map(), nullptr) << "all belongs together again";
}

TEST(NearMap, HoldsWhatBelongsOnly) {
  const PlacedScans keys = drive_through_rooms(6);
  NearMap near;
  add(keys, {true, false, true, false, false, false}, false, near);
  ASSERT_NE(near.map(), nullptr);
  EXPECT_TRUE(same_map(*near.map(), inserted({keys[1], keys[3], keys[4], keys[5]})));
  near.clear();
  EXPECT_EQ(near.map(), nullptr);
}

TEST(NearMap, LooksNoFartherThanTheRobotSees) {
  PlacedScans keys = drive_through_rooms(4);
  const Pose2& newest = keys.back().map_from_base;
  keys[0].map_from_base = Pose2{newest.x + 14.9, newest.y, 0.0};
  keys[1].map_from_base = Pose2{newest.x, newest.y - 15.1, 0.0};
  NearMap near;
  add(keys, {false, true, false, false}, false, near);
  EXPECT_EQ(near.map(), nullptr) << "what lies apart is far";
  add(keys, {false, false, true, false}, false, near);
  ASSERT_NE(near.map(), nullptr);
  EXPECT_TRUE(same_map(*near.map(), inserted({keys[0], keys[3]})));
}

TEST(NearMap, TakesNewKeyScansInUntilItHasMovedFarEnough) {
  const PlacedScans keys = drive_through_rooms(24);
  NearMap near;
  PlacedScans expected = {keys[1], keys[2]};
  Eigen::Vector2d center = keys[2].map_from_base.translation();
  int renewed = 0;
  for (std::size_t count = 3; count <= keys.size(); ++count) {
    const PlacedScans so_far(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(count));
    // From the fourth on the second one lies apart, too.
    std::vector<bool> is_apart(count, false);
    is_apart[0] = true;
    is_apart[1] = count > 3;
    add(so_far, is_apart, false, near);
    if (count > 3) {
      expected.push_back(so_far.back());
      if ((so_far.back().map_from_base.translation() - center).norm() >= 5.0) {
        expected = {so_far.begin() + 2, so_far.end()};
        center = so_far.back().map_from_base.translation();
        ++renewed;
      }
    }
    ASSERT_NE(near.map(), nullptr);
    ASSERT_TRUE(same_map(*near.map(), inserted(expected))) << count;
  }
  EXPECT_GE(renewed, 1);
}

}  // namespace
}  // namespace matchbox_slam
