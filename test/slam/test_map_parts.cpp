#include <gtest/gtest.h>

#include "slam/key_scans_of_rooms.hpp"
#include "slam/map_parts.hpp"

namespace matchbox_slam {
namespace {

const PlacedScans& keys() {
  static const PlacedScans all = drive_through_rooms(4);
  return all;
}

/// With so many key scans.
MapPart part(std::size_t key_scans, double begin = 0.0) {
  MapPart made{SlamMap(MapOptions{}, LikelihoodFieldOptions{}), {}, {}, begin};
  for (std::size_t i = 0; i < key_scans; ++i) {
    made.key_scans.add(keys()[i]);
  }
  return made;
}

const Pose2 kMapFromApart{3.0, 1.0, 0.5};

TEST(MapParts, ALostRobotGetsAPartOfItsOwn) {
  MapParts parts({part(3)});
  EXPECT_FALSE(parts.is_lost());
  EXPECT_FALSE(parts.begin_apart(part(0, 7.0)));
  EXPECT_TRUE(parts.is_lost());
  EXPECT_EQ(parts.here().begin, 7.0);
  EXPECT_EQ(parts.here().left, 0U);
  EXPECT_EQ(parts.map().key_scans.size(), 3U);
}

TEST(MapParts, APartThatHoldsHardlyAnythingIsBegunAnew) {
  MapParts parts({part(3)});
  static_cast<void>(parts.begin_apart(part(2, 7.0)));
  parts.wait({{1, keys()[0]}, {0, keys()[1]}});
  static_cast<void>(parts.begin_apart(part(0, 9.0)));
  EXPECT_EQ(parts.all().size(), 2U);
  EXPECT_EQ(parts.here().begin, 7.0) << "since then nobody knows where the robot is";
  ASSERT_EQ(parts.waiting().size(), 1U);
  EXPECT_EQ(parts.waiting().front().part, 0U);
}

TEST(MapParts, JoinedKeyScansWaitWhereTheyBelong) {
  MapParts parts({part(1)});
  static_cast<void>(parts.begin_apart(part(2)));
  parts.wait({{1, keys()[2]}});
  parts.join(0, kMapFromApart, true);
  EXPECT_FALSE(parts.is_lost());
  EXPECT_EQ(parts.all().size(), 1U);
  ASSERT_EQ(parts.waiting().size(), 3U) << "and what waited for that part before them";
  const std::size_t order[] = {2, 0, 1};
  for (const std::size_t i : order) {
    const WaitingScan* next = parts.next_waiting();
    ASSERT_NE(next, nullptr);
    EXPECT_EQ(next->part, 0U);
    EXPECT_EQ(next->scan.map_from_base, kMapFromApart * keys()[i].map_from_base);
    parts.drop_next_waiting();
  }
  EXPECT_EQ(parts.next_waiting(), nullptr);
}

TEST(MapParts, WhatIsNotToGrowTakesNoKeyScans) {
  MapParts parts({part(1)});
  static_cast<void>(parts.begin_apart(part(2)));
  parts.join(0, kMapFromApart, false);
  EXPECT_TRUE(parts.waiting().empty());
}

TEST(MapParts, PartsThatFollowedAJoinedOneFollowItsHeir) {
  MapParts parts({part(1)});
  static_cast<void>(parts.begin_apart(part(3)));
  static_cast<void>(parts.begin_apart(part(3)));
  parts.wait({{2, keys()[0]}});
  const Pose2 first_from_second{0.0, 2.0, 0.1};
  parts.here().left_from_here = first_from_second;
  EXPECT_EQ(parts.here().left, 1U);
  // The robot is found in the first of them: one part apart is left, which is 1.
  parts.join(1, first_from_second, true);
  EXPECT_TRUE(parts.is_lost());
  EXPECT_EQ(parts.here_number(), 1U);
  EXPECT_EQ(parts.here().left, 0U);
  for (const WaitingScan& scan : parts.waiting()) {
    EXPECT_EQ(scan.part, 1U);
  }
}

TEST(MapParts, TheSmallestIsGivenUpWhenThereAreTooMany) {
  MapParts parts({part(1)});
  for (std::size_t i = 0; i < kMostPartsApart; ++i) {
    EXPECT_FALSE(parts.begin_apart(part(i == 4 ? 3 : 4, static_cast<double>(i))));
  }
  parts.wait({{5, keys()[0]}, {6, keys()[1]}});
  EXPECT_TRUE(parts.begin_apart(part(0, 99.0)));
  ASSERT_EQ(parts.all().size(), kMostPartsApart + 1);
  for (const MapPart& one : parts.all()) {
    EXPECT_NE(one.begin, 4.0);
  }
  EXPECT_EQ(parts.here().begin, 99.0);
  ASSERT_EQ(parts.waiting().size(), 1U) << "what waited for it is gone";
  EXPECT_EQ(parts.waiting().front().part, 5U) << "those behind it have lower numbers";
  EXPECT_EQ(parts.all()[5].left, 4U) << "its follower goes on from the one that it followed";
  EXPECT_EQ(parts.all()[6].left, 5U);
}

TEST(MapParts, ARobotThatIsToldItsPlaceIsInTheMap) {
  MapParts parts({part(1)});
  static_cast<void>(parts.begin_apart(part(3, 7.0)));
  parts.wait({{1, keys()[0]}});
  parts.go_to_map();
  EXPECT_FALSE(parts.is_lost());
  EXPECT_TRUE(parts.waiting().empty());
  EXPECT_GT(parts.all()[1].begin, 1e9) << "no pose is put right when that is joined one day";
}

TEST(MapParts, ACorrectionOfTheMapMovesWhatWaitsForIt) {
  MapParts parts({part(1)});
  static_cast<void>(parts.begin_apart(part(3)));
  parts.wait({{0, keys()[0]}, {1, keys()[1]}});
  parts.move_waiting_for_map(kMapFromApart);
  EXPECT_EQ(parts.waiting()[0].scan.map_from_base, kMapFromApart * keys()[0].map_from_base);
  EXPECT_EQ(parts.waiting()[1].scan.map_from_base, keys()[1].map_from_base);
}

}  // namespace
}  // namespace matchbox_slam
