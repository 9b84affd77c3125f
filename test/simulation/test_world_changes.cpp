#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "simulation/make_world.hpp"
#include "simulation/world_changes.hpp"

namespace matchbox_slam {
namespace {

WorldChangeOptions moving(double share) {
  WorldChangeOptions options;
  options.moved = share;
  return options;
}

bool is_same(const WallSegment& a, const WallSegment& b) {
  return a.start == b.start && a.end == b.end;
}

bool has(const World& world, const WallSegment& line) {
  return std::any_of(world.segments().begin(), world.segments().end(),
                     [&](const WallSegment& other) { return is_same(line, other); });
}

/// Lines of one world that the other one has not.
std::vector<WallSegment> only_in(const World& world, const World& other) {
  std::vector<WallSegment> lines;
  std::copy_if(world.segments().begin(), world.segments().end(), std::back_inserter(lines),
               [&](const WallSegment& line) { return !has(other, line); });
  return lines;
}

double total_length(const std::vector<WallSegment>& lines) {
  double sum = 0.0;
  for (const WallSegment& line : lines) {
    sum += line.length();
  }
  return sum;
}

/// How near lines come to the route [m].
double nearest(const std::vector<WallSegment>& lines, const Route& route) {
  double least = 1e9;
  for (std::size_t i = 1; i < route.waypoints.size(); ++i) {
    const WallSegment way{route.waypoints[i - 1], route.waypoints[i]};
    for (const WallSegment& line : lines) {
      least = std::min(least, distance(line, way));
    }
  }
  return least;
}

bool are_same(const World& a, const World& b) {
  return std::equal(a.segments().begin(), a.segments().end(), b.segments().begin(),
                    b.segments().end(), is_same);
}

TEST(WorldChanges, NoneLeaveEachSegmentInItsPlace) {
  const World world = make_world("rooms", 2);
  EXPECT_TRUE(are_same(changed(world, {}).world, world));
}

TEST(WorldChanges, HalfOfTheFurnitureStandsElsewhereOffTheRoute) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const World world = make_world("rooms", seed);
    const ChangedWorld other = changed(world, moving(0.5));
    const auto things = static_cast<double>(world.things().size());
    EXPECT_GT(static_cast<double>(other.moved), 0.35 * things);
    EXPECT_LT(static_cast<double>(other.moved), 0.65 * things);
    const std::vector<WallSegment> gone = only_in(world, other.world);
    const std::vector<WallSegment> come = only_in(other.world, world);
    EXPECT_EQ(gone.size(), come.size());
    EXPECT_NEAR(total_length(gone), total_length(come), 1e-9);
    EXPECT_GT(nearest(come, world.route()), 0.42);
    EXPECT_EQ(other.world.things().size(), world.things().size());
    EXPECT_EQ(other.world.route().waypoints, world.route().waypoints);
  }
}

TEST(WorldChanges, AThingStaysOnItsSideOfTheWallsAndALeafOnItsHinge) {
  const WallSegment wall{{-5.0, 1.0}, {5.0, 1.0}};
  std::vector<WallSegment> segments = {wall};
  for (const double x : {-3.0, 0.0, 3.0}) {
    segments.push_back({{x, 0.5}, {x + 0.5, 0.5}});
  }
  const Eigen::Vector2d hinge = segments.back().start;
  const World world(segments, {0.0, {{-5.0, -4.0}, {5.0, -4.0}}}, {}, 0,
                    {{1, 2, {}}, {2, 3, {}}, {3, 4, hinge}});
  for (int seed = 0; seed < 50; ++seed) {
    WorldChangeOptions options = moving(1.0);
    options.change_seed = seed;
    const ChangedWorld other = changed(world, options);
    EXPECT_EQ(other.moved, 3U);
    for (const WallSegment& line : only_in(other.world, world)) {
      EXPECT_LT(std::max(line.start.y(), line.end.y()), 1.0);
    }
    EXPECT_LT((other.world.segments().back().start - hinge).norm(), 1e-9);
    EXPECT_NE(other.world.segments().back().end, segments.back().end);
  }
}

TEST(WorldChanges, WhatIsTakenIsGone) {
  const World world = make_world("rooms", 1);
  WorldChangeOptions options;
  options.taken = 0.2;
  const ChangedWorld other = changed(world, options);
  EXPECT_GT(other.taken, 5U);
  EXPECT_EQ(other.world.things().size() + other.taken, world.things().size());
  EXPECT_TRUE(only_in(other.world, world).empty());
  EXPECT_FALSE(only_in(world, other.world).empty());
}

TEST(WorldChanges, WallsAreBuiltFromWallsOffTheRoute) {
  const World world = make_world("rooms", 1);
  WorldChangeOptions options;
  options.walls = 5;
  const ChangedWorld other = changed(world, options);
  EXPECT_EQ(other.built, 5U);
  const std::vector<WallSegment> come = only_in(other.world, world);
  EXPECT_EQ(come.size(), 4 * other.built);  // a box each
  EXPECT_GT(total_length(come), 2.0 * 5.0);
  EXPECT_GT(nearest(come, world.route()), 0.65);
  std::vector<WallSegment> walls = world.segments();
  for (std::size_t i = 0; i < come.size(); i += 4) {
    const auto begin = come.begin() + static_cast<std::ptrdiff_t>(i);
    EXPECT_TRUE(std::any_of(begin, begin + 4, [&](const WallSegment& line) {
      return std::any_of(walls.begin(), walls.end(),
                         [&](const WallSegment& wall) { return distance(line, wall) < 1e-6; });
    })) << i;
    walls.insert(walls.end(), begin, begin + 4);
  }
}

TEST(WorldChanges, WhereThereAreNoWallsNoneAreBuilt) {
  for (const char* const name : {"random", "street"}) {
    const World world = make_world(name, 1);
    WorldChangeOptions options;
    options.walls = 2;
    const ChangedWorld other = changed(world, options);
    EXPECT_EQ(other.built, 0U) << name;
    EXPECT_TRUE(only_in(other.world, world).empty()) << name;
  }
}

/// How near things come to each other [m].
double least_gap(const World& world) {
  double least = 1e9;
  for (const Thing& a : world.things()) {
    for (const Thing& b : world.things()) {
      for (std::size_t i = a.begin; &a != &b && i < a.end; ++i) {
        for (std::size_t j = b.begin; j < b.end; ++j) {
          least = std::min(least, distance(world.segments()[i], world.segments()[j]));
        }
      }
    }
  }
  return least;
}

TEST(WorldChanges, NothingIsPutWhereAnotherThingStands) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const World world = make_world("rooms", seed);
    const double before = least_gap(world);
    EXPECT_GE(least_gap(changed(world, moving(0.8)).world), std::min(before, 0.1)) << seed;
  }
}

TEST(WorldChanges, PeopleWalkOn) {
  const World world = make_world("hall", 1);
  const World other = changed(world, moving(0.5)).world;
  ASSERT_EQ(other.walks().size(), world.walks().size());
  const auto walking = [](const World& some) {
    return std::count_if(some.segments().begin(), some.segments().end(),
                         [](const WallSegment& line) { return line.surface.walk.has_value(); });
  };
  EXPECT_GT(walking(world), 0);
  EXPECT_EQ(walking(other), walking(world));
}

TEST(WorldChanges, TheSameSeedGivesTheSameDay) {
  const World world = make_world("rooms", 4);
  WorldChangeOptions options = moving(0.3);
  const World day = changed(world, options).world;
  EXPECT_TRUE(are_same(day, changed(world, options).world));
  options.change_seed = 2;
  EXPECT_FALSE(are_same(day, changed(world, options).world));
}

}  // namespace
}  // namespace matchbox_slam
