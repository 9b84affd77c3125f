#include <gtest/gtest.h>

#include "merging/map_agreement.hpp"
#include "simulation/make_world.hpp"
#include "slam/maps_of_rooms.hpp"

namespace matchbox_slam {
namespace {

PlacedScans moved(const PlacedScans& keys, const Pose2& new_from_old) {
  PlacedScans moved = keys;
  for (PlacedScan& key : moved) {
    key.map_from_base = new_from_old * key.map_from_base;
  }
  return moved;
}

TEST(MapAgreement, MapsAgreeWhereTheyLieRightlyAndNowhereElse) {
  const KeyScans one = map_of_way(3, 0, 60, {}).key_scans;
  const KeyScans other = map_of_way(3, 30, 90, {}).key_scans;
  EXPECT_TRUE(do_agree(one.all(), other.all(), {}));
  const Agreement right = agreement_of(one.all(), other.all(), {});
  EXPECT_GE(right.near, 30U);
  EXPECT_EQ(right.against, 0U);
  for (const Pose2& off : {Pose2{1.0, 0.0, 0.0}, Pose2{0.0, -1.0, 0.0}, Pose2{0.0, 0.0, 0.2}}) {
    EXPECT_FALSE(do_agree(one.all(), moved(other.all(), off), {})) << off.x << " " << off.y;
  }
}

TEST(MapAgreement, MapsThatShareNoGroundDoNotDisagree) {
  const KeyScans one = map_of_way(3, 0, 10, {}).key_scans;
  const Agreement apart = agreement_of(one.all(), moved(one.all(), {500.0, 0.0, 0.0}), {});
  EXPECT_EQ(apart.near, 0U);
  EXPECT_EQ(apart.share_against(), 0.0);
}

TEST(MapAgreement, ARailingThatHalfOfTheBeamsPassSpeaksAgainstNobody) {
  const World world = make_atrium_world(1);
  const RobotMotion motion = drive(world.route(), {});
  const KeyScans one = map_in(world, motion, 0, 80, {}).key_scans;
  const KeyScans other = map_in(world, motion, 40, 120, {}, 7).key_scans;
  EXPECT_TRUE(do_agree(one.all(), other.all(), {}));
  const Agreement agreement = agreement_of(other.all(), one.all(), {});
  EXPECT_GE(agreement.near, 40U);
  EXPECT_EQ(agreement.against, 0U);
}

}  // namespace
}  // namespace matchbox_slam
