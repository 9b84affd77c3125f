#include <gtest/gtest.h>

#include "slam/key_scans_of_rooms.hpp"
#include "slam/map_components.hpp"

namespace matchbox_slam {
namespace {

const PlacedScans& keys() {
  static const PlacedScans all = drive_through_rooms(4);
  return all;
}

/// With so many key scans.
MapComponent component(std::size_t key_scans, double begin = 0.0) {
  MapComponent made{SlamMap(MapOptions{}, LikelihoodFieldOptions{}), {}, {}, begin};
  for (std::size_t i = 0; i < key_scans; ++i) {
    made.key_scans.add(keys()[i]);
  }
  return made;
}

/// The same with these that wait.
MapComponents waiting(const MapComponents& components, const std::vector<WaitingScan>& scans) {
  return MapComponents(components.all(), components.active_number(), scans);
}

const Pose2 kMapFromComponent{3.0, 1.0, 0.5};

TEST(MapComponents, ALostRobotGetsAComponentOfItsOwn) {
  MapComponents components({component(3)});
  EXPECT_FALSE(components.is_lost());
  EXPECT_FALSE(components.begin_component(component(0, 7.0)));
  EXPECT_TRUE(components.is_lost());
  EXPECT_EQ(components.active().begin, 7.0);
  EXPECT_EQ(components.active().parent, 0U);
  EXPECT_EQ(components.map().key_scans.size(), 3U);
}

TEST(MapComponents, AComponentThatHoldsHardlyAnythingIsBegunAnew) {
  MapComponents components({component(3)});
  static_cast<void>(components.begin_component(component(2, 7.0)));
  components = waiting(components, {{1, keys()[0]}, {0, keys()[1]}});
  static_cast<void>(components.begin_component(component(0, 9.0)));
  EXPECT_EQ(components.all().size(), 2U);
  EXPECT_EQ(components.active().begin, 7.0) << "since then nobody knows where the robot is";
  ASSERT_EQ(components.waiting().size(), 1U);
  EXPECT_EQ(components.waiting().front().component, 0U);
}

TEST(MapComponents, JoinedKeyScansWaitWhereTheyBelong) {
  MapComponents components({component(1)});
  static_cast<void>(components.begin_component(component(2)));
  components = waiting(components, {{1, keys()[2]}});
  components.join(0, kMapFromComponent, true);
  EXPECT_FALSE(components.is_lost());
  EXPECT_EQ(components.all().size(), 1U);
  ASSERT_EQ(components.waiting().size(), 3U) << "and what waited for that component before them";
  const std::size_t order[] = {2, 0, 1};
  for (const std::size_t i : order) {
    const WaitingScan* next = components.next_waiting();
    ASSERT_NE(next, nullptr);
    EXPECT_EQ(next->component, 0U);
    EXPECT_EQ(next->scan.map_from_base, kMapFromComponent * keys()[i].map_from_base);
    components.drop_next_waiting();
  }
  EXPECT_EQ(components.next_waiting(), nullptr);
}

TEST(MapComponents, WhatIsNotToGrowTakesNoKeyScans) {
  MapComponents components({component(1)});
  static_cast<void>(components.begin_component(component(2)));
  components.join(0, kMapFromComponent, false);
  EXPECT_TRUE(components.waiting().empty());
}

TEST(MapComponents, ComponentsThatFollowedAJoinedOneFollowItsHeir) {
  MapComponents components({component(1)});
  static_cast<void>(components.begin_component(component(3)));
  static_cast<void>(components.begin_component(component(3)));
  components = waiting(components, {{2, keys()[0]}});
  const Pose2 first_from_second{0.0, 2.0, 0.1};
  components.active().parent_from_component = first_from_second;
  EXPECT_EQ(components.active().parent, 1U);
  // The robot is found in the first of them: one component besides the map is left, which is 1.
  components.join(1, first_from_second, true);
  EXPECT_TRUE(components.is_lost());
  EXPECT_EQ(components.active_number(), 1U);
  EXPECT_EQ(components.active().parent, 0U);
  for (const WaitingScan& scan : components.waiting()) {
    EXPECT_EQ(scan.component, 1U);
  }
}

TEST(MapComponents, TheSmallestIsGivenUpWhenThereAreTooMany) {
  MapComponents components({component(1)});
  for (std::size_t i = 0; i < kMostDisconnectedComponents; ++i) {
    EXPECT_FALSE(components.begin_component(component(i == 4 ? 3 : 4, static_cast<double>(i))));
  }
  components = waiting(components, {{5, keys()[0]}, {6, keys()[1]}});
  EXPECT_TRUE(components.begin_component(component(0, 99.0)));
  ASSERT_EQ(components.all().size(), kMostDisconnectedComponents + 1);
  for (const MapComponent& one : components.all()) {
    EXPECT_NE(one.begin, 4.0);
  }
  EXPECT_EQ(components.active().begin, 99.0);
  ASSERT_EQ(components.waiting().size(), 1U) << "what waited for it is gone";
  EXPECT_EQ(components.waiting().front().component, 5U) << "those behind it have lower numbers";
  EXPECT_EQ(components.all()[5].parent, 4U) << "its follower goes on from the one that it followed";
  EXPECT_EQ(components.all()[6].parent, 5U);
}

TEST(MapComponents, ARobotThatIsToldItsPlaceIsInTheMap) {
  MapComponents components({component(1)});
  static_cast<void>(components.begin_component(component(3, 7.0)));
  components = waiting(components, {{1, keys()[0]}});
  components.go_to_map();
  EXPECT_FALSE(components.is_lost());
  EXPECT_TRUE(components.waiting().empty());
  EXPECT_GT(components.all()[1].begin, 1e9) << "no pose is put right when that is joined one day";
}

TEST(MapComponents, ACorrectionOfTheMapMovesWhatWaitsForIt) {
  MapComponents components({component(1)});
  static_cast<void>(components.begin_component(component(3)));
  components = waiting(components, {{0, keys()[0]}, {1, keys()[1]}});
  components.move_waiting_for_map(kMapFromComponent);
  EXPECT_EQ(components.waiting()[0].scan.map_from_base,
            kMapFromComponent * keys()[0].map_from_base);
  EXPECT_EQ(components.waiting()[1].scan.map_from_base, keys()[1].map_from_base);
}

}  // namespace
}  // namespace matchbox_slam
