#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/random.hpp"
#include "simulation/laser.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {
namespace {

Eigen::Vector2d direction_of(double angle) { return {std::cos(angle), std::sin(angle)}; }

World square_room() {
  return {{{{-2.0, -2.0}, {2.0, -2.0}},
           {{2.0, -2.0}, {2.0, 2.0}},
           {{2.0, 2.0}, {-2.0, 2.0}},
           {{-2.0, 2.0}, {-2.0, -2.0}}},
          {}};
}

/// The oracle: every segment is tried.
std::optional<RayHit> cast_ray_by_brute_force(const World& world, const Eigen::Vector2d& origin,
                                              const Eigen::Vector2d& direction, double max_range,
                                              const RayMoment& moment) {
  std::optional<RayHit> best;
  for (std::size_t i = 0; i < world.segments().size(); ++i) {
    const WallSegment& segment = world.segments()[i];
    Eigen::Vector2d then = origin;  // as seen from the thing where it is at time 0
    if (segment.surface.walk) {
      const Walk& walk = world.walks()[*segment.surface.walk];
      then = origin - walk.at(moment.time) + walk.at(0.0);
    }
    const auto range = intersect_ray(segment, then, direction);
    if (range && *range <= max_range && (!best || *range < best->range) &&
        !lets_pass(segment, direction, mix_seed(moment.chance, i))) {
      const Eigen::Vector2d normal = segment.normal();
      best = RayHit{*range, i, normal.dot(direction) > 0.0 ? -normal : normal};
    }
  }
  if (best) {
    best->range +=
        depth_of_return(world.segments()[best->segment], mix_seed(~moment.chance, best->segment));
  }
  return best;
}

bool are_same_segments(const World& a, const World& b) {
  return std::equal(a.segments().begin(), a.segments().end(), b.segments().begin(),
                    b.segments().end(), [](const WallSegment& p, const WallSegment& q) {
                      return p.start == q.start && p.end == q.end;
                    });
}

TEST(World, RaysInASquareRoomHitWhereGeometrySays) {
  const World room = square_room();
  for (double angle = -3.1; angle < 3.1; angle += 0.01) {
    const Eigen::Vector2d direction = direction_of(angle);
    const auto hit = room.cast_ray({0.0, 0.0}, direction, 10.0);
    ASSERT_TRUE(hit) << angle;
    EXPECT_NEAR(hit->range, 2.0 / direction.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(hit->normal.dot(direction), 0.0);
    EXPECT_NEAR(hit->normal.norm(), 1.0, 1e-12);
  }
  const auto right = room.cast_ray({1.0, 0.5}, {1.0, 0.0}, 10.0);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->segment, 1U);
  EXPECT_DOUBLE_EQ(right->range, 1.0);
  EXPECT_EQ(right->normal, Eigen::Vector2d(-1.0, 0.0));
}

TEST(World, WallsReflectOnBothSides) {
  const auto hit = square_room().cast_ray({5.0, 0.0}, {-1.0, 0.0}, 10.0);
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->range, 3.0);
  EXPECT_EQ(hit->normal, Eigen::Vector2d(1.0, 0.0));
}

TEST(World, ARayIntoACornerIsNotLostBetweenTheWalls) {
  const World room = square_room();
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform(-1.9, 1.9);
    const Eigen::Vector2d origin(x, random.uniform(-1.9, 1.9));
    const Eigen::Vector2d to_corner = Eigen::Vector2d(2.0, 2.0) - origin;
    const auto hit = room.cast_ray(origin, to_corner.normalized(), 10.0);
    ASSERT_TRUE(hit) << origin.transpose();
    ASSERT_NEAR(hit->range, to_corner.norm(), 1e-6);
  }
}

TEST(World, NothingIsHitBeyondTheReachNorInAnEmptyWorld) {
  EXPECT_FALSE(square_room().cast_ray({0.0, 0.0}, {1.0, 0.0}, 1.999));
  EXPECT_TRUE(square_room().cast_ray({0.0, 0.0}, {1.0, 0.0}, 2.0));
  EXPECT_FALSE(square_room().cast_ray({5.0, 0.0}, {1.0, 0.0}, 100.0));
  const World empty({}, {});
  EXPECT_FALSE(empty.cast_ray({0.0, 0.0}, {1.0, 0.0}, 100.0));
  EXPECT_EQ(clearance(empty, {0.0, 0.0}), std::numeric_limits<double>::infinity());
}

TEST(World, RefusesSegmentsWithoutLength) {
  EXPECT_THROW(World({{{1.0, 1.0}, {1.0, 1.0}}}, {}), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(World({{{1.0, nan}, {1.0, 1.0}}}, {}), std::invalid_argument);
}

/// A walker, 0.2 m thick, that goes up and down the y axis between -3 m and 3 m in 12 s.
World with_a_walker() {
  WallSurface walking;
  walking.walk = 0;
  return {{{{-0.1, -4.0}, {-0.1, -2.0}, false, walking}, {{5.0, -9.0}, {5.0, 9.0}}},
          {},
          {Walk({{0.0, -3.0}, {0.0, 3.0}}, 1.0, 0.0)}};
}

TEST(World, WhatWalksIsMetWhereItIsThen) {
  const World world = with_a_walker();
  for (double time = -30.0; time < 30.0; time += 0.5) {
    for (double y = -4.55; y < 5.0; y += 0.7) {
      const auto hit = world.cast_ray({-2.0, y}, {1.0, 0.0}, 10.0, {}, {time, 0});
      ASSERT_TRUE(hit);
      const bool is_there = std::abs(world.walks()[0].at(time).y() - y) < 1.0;
      EXPECT_EQ(hit->segment, is_there ? 0U : 1U) << time << " at " << y;
      EXPECT_NEAR(hit->range, is_there ? 1.9 : 7.0, 1e-9);
    }
  }
}

TEST(World, WhatWalksHidesNothingThatIsNearer) {
  const World world = with_a_walker();
  EXPECT_EQ(world.cast_ray({6.0, -3.0}, {-1.0, 0.0}, 10.0)->segment, 1U);
  EXPECT_FALSE(world.cast_ray({-2.0, -3.0}, {1.0, 0.0}, 1.8));
  EXPECT_TRUE(world.cast_ray({-2.0, -3.0}, {1.0, 0.0}, 2.0));
}

TEST(World, RefusesAWayThatThereIsNot) {
  WallSurface walking;
  walking.walk = 1;
  EXPECT_THROW(World({{{0.0, 0.0}, {1.0, 0.0}, false, walking}}, {},
                     {Walk({{0.0, 0.0}, {1.0, 0.0}}, 1.0, 0.0)}),
               std::invalid_argument);
}

TEST(World, ClearanceIsTheDistanceToTheNearestWall) {
  EXPECT_DOUBLE_EQ(clearance(square_room(), {1.5, 0.0}), 0.5);
  EXPECT_DOUBLE_EQ(clearance(square_room(), {5.0, 6.0}), 5.0);
}

TEST(World, DistanceOfSegments) {
  const WallSegment flat{{0.0, 0.0}, {2.0, 0.0}};
  EXPECT_DOUBLE_EQ(distance(flat, WallSegment{{1.0, -1.0}, {1.0, 1.0}}), 0.0);
  EXPECT_DOUBLE_EQ(distance(flat, WallSegment{{1.0, 0.5}, {1.0, 1.0}}), 0.5);
  EXPECT_DOUBLE_EQ(distance(flat, WallSegment{{5.0, 4.0}, {5.0, 9.0}}), 5.0);
}

class NamedWorld : public testing::TestWithParam<const char*> {};

TEST_P(NamedWorld, TheGridFindsWhatBruteForceFinds) {
  const World world = make_world(GetParam(), 3);
  Random random(4);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = random.uniform(-15.0, 40.0);
    const Eigen::Vector2d origin(x, random.uniform(-15.0, 25.0));
    // Every tenth ray runs along an axis, on which the grid's cells and most walls lie.
    const double angle = i % 10 == 0 ? 0.5 * kPi * (i / 10 % 4) : random.uniform(-kPi, kPi);
    const RayMoment moment{0.1 * i, random.next()};
    const auto expected = cast_ray_by_brute_force(world, origin, direction_of(angle), 30.0, moment);
    const auto hit = world.cast_ray(origin, direction_of(angle), 30.0, {}, moment);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << origin.transpose() << " at " << angle;
    if (hit) {
      ++hits;
      ASSERT_EQ(hit->range, expected->range) << origin.transpose() << " at " << angle;
      ASSERT_EQ(hit->segment, expected->segment);
      ASSERT_EQ(hit->normal, expected->normal);
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST_P(NamedWorld, TheSeedSaysEverything) {
  const World world = make_world(GetParam(), 11);
  const World same = make_world(GetParam(), 11);
  EXPECT_TRUE(are_same_segments(world, same));
  EXPECT_EQ(world.route().waypoints, same.route().waypoints);
  EXPECT_EQ(world.route().start_heading, same.route().start_heading);
  EXPECT_FALSE(are_same_segments(world, make_world(GetParam(), 12)));
}

TEST_P(NamedWorld, TheRobotKeepsClearOfTheWalls) {
  const std::uint64_t seeds = GetParam() == std::string("campus") ? 1 : 20;  // 3 km each
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const World world = make_world(GetParam(), seed);
    const RobotMotion motion = drive(world.route(), {});
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < motion.steps().size(); i += 10) {
      least = std::min(least, clearance(world, motion.steps()[i].world_from_base.translation()));
    }
    EXPECT_GT(least, 0.4) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(All, NamedWorld,
                         testing::Values("rooms", "random", "corridor", "loop", "campus", "hotel",
                                         "atrium", "glass", "street", "hall", "warehouse", "garage",
                                         "park", "mine", "greenhouse"),
                         [](const auto& test) { return std::string(test.param); });

TEST(MakeWorld, KnowsItsNamesAndNamesWhatItKnows) {
  for (const std::string& name : world_names()) {
    EXPECT_FALSE(make_world(name, 1).segments().empty()) << name;
  }
  try {
    (void)make_world("room", 1);
    FAIL() << "accepted an unknown name";
  } catch (const ConfigurationError& error) {
    const std::string text = error.what();
    for (const char* word :
         {"'room'", "rooms", "random", "corridor", "loop", "campus", "hotel", "atrium", "glass",
          "street", "hall", "warehouse", "garage", "park", "mine", "greenhouse"}) {
      EXPECT_NE(text.find(word), std::string::npos) << text;
    }
  }
}

/// The largest share of a scan's hits that lie within 2 cm of one line.
double share_on_one_line(const LaserScan& scan) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (std::isfinite(scan.ranges[i])) {
      const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      points.emplace_back(static_cast<double>(scan.ranges[i]) * direction_of(angle));
    }
  }
  std::size_t most = 0;
  for (double angle = 0.0; angle < kPi; angle += 0.005) {
    std::vector<double> offsets;
    for (const Eigen::Vector2d& point : points) {
      offsets.push_back(point.dot(direction_of(angle)));
    }
    std::sort(offsets.begin(), offsets.end());
    for (std::size_t first = 0, last = 0; last < offsets.size(); ++last) {
      while (offsets[last] - offsets[first] > 0.04) {
        ++first;
      }
      most = std::max(most, last - first + 1);
    }
  }
  return static_cast<double>(most) / static_cast<double>(points.size());
}

TEST(RandomWorld, HasNoLongStraightLine) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const World world = make_random_world(seed);
    for (const WallSegment& segment : world.segments()) {
      ASSERT_LT(segment.length(), 0.6);
    }
    const Eigen::Vector2d start = world.route().waypoints.front();
    EXPECT_LT(share_on_one_line(ideal_scan(world, {}, {start.x(), start.y(), 0.0})), 0.2);
  }
  const World rooms = make_rooms_world(0);
  const Eigen::Vector2d start = rooms.route().waypoints.front();
  EXPECT_GT(share_on_one_line(ideal_scan(rooms, {}, {start.x(), start.y(), 0.0})), 0.3);
}

TEST(RandomWorld, MostBeamsEndWithinTenMetres) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const World world = make_random_world(seed);
    const Eigen::Vector2d start = world.route().waypoints.front();
    const LaserScan scan = ideal_scan(world, {}, {start.x(), start.y(), 0.0});
    const auto near = std::count_if(scan.ranges.begin(), scan.ranges.end(),
                                    [](float range) { return range < 10.0F; });
    EXPECT_GT(near, 600);
  }
}

TEST(LoopWorld, IsAHundredMetresAroundAndTheRouteOverlaps) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const World world = make_loop_world(seed);
    EXPECT_NEAR(length_of(world.route()), 116.0, 1.0);
    const std::vector<Eigen::Vector2d>& points = world.route().waypoints;
    // The last stretch runs along the first one: its end lies 16 m ahead of the start.
    EXPECT_NEAR((points.back() - points.front()).norm(), std::hypot(12.5, 3.5), 0.3);
  }
}

TEST(CorridorWorld, LooksTheSameAllAlong) {
  const World world = make_corridor_world(1);
  const LaserScan first = ideal_scan(world, {}, {40.0, 0.1, 0.2});
  const LaserScan second = ideal_scan(world, {}, {80.0, 0.1, 0.2});
  ASSERT_EQ(first.ranges.size(), second.ranges.size());
  for (std::size_t i = 0; i < first.ranges.size(); ++i) {
    if (std::isfinite(first.ranges[i])) {
      EXPECT_NEAR(first.ranges[i], second.ranges[i], 1e-5);
    } else {
      EXPECT_EQ(first.ranges[i], second.ranges[i]);
    }
  }
}

TEST(RoomsWorld, TheRouteIsATourThatComesBack) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Route route = make_rooms_world(seed).route();
    EXPECT_EQ(route.waypoints.front(), route.waypoints.back());
    EXPECT_GT(length_of(route), 50.0);
    EXPECT_LT(length_of(route), 125.0);
  }
}

TEST(CampusWorld, TheRouteIsATourOfThreeKilometres) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Route route = make_campus_world(seed).route();
    EXPECT_EQ(route.waypoints.front(), route.waypoints.back());
    EXPECT_GT(length_of(route), 2900.0);
    EXPECT_LT(length_of(route), 3300.0);
  }
}

TEST(HotelWorld, NothingTellsOneRoomFromTheNext) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const World world = make_hotel_world(seed);
    const std::vector<Eigen::Vector2d>& points = world.route().waypoints;
    EXPECT_EQ(points.front(), points.back());
    std::vector<LaserScan> inside;  // of rooms, towards their doors
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      if (points[i - 1] == points[i + 1]) {
        const Eigen::Vector2d out = points[i + 1] - points[i];
        inside.push_back(
            ideal_scan(world, {}, {points[i].x(), points[i].y(), std::atan2(out.y(), out.x())}));
      }
    }
    ASSERT_GT(inside.size(), 3U);
    for (const LaserScan& scan : inside) {
      std::size_t same = 0;
      for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
        same += std::abs(scan.ranges[i] - inside.front().ranges[i]) < 1e-4F ? 1 : 0;
      }
      EXPECT_GT(same, scan.ranges.size() - 10) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
