#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "simulation/make_world.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

constexpr std::uint64_t kSeeds = 5;

/// The same world with nothing but opaque walls, of the same numbers.
World as_opaque(const World& world) {
  std::vector<WallSegment> segments;
  for (WallSegment segment : world.segments()) {
    if (!segment.surface.walk) {
      segment.surface = {};
      segments.push_back(segment);
    }
  }
  return {segments, world.route()};
}

LaserOptions all_round() {
  LaserOptions laser = without_noise(LaserOptions{});
  laser.field_of_view = 2.0 * kPi;
  laser.range_max = 60.0;
  return laser;
}

/// A beam, and what it would meet were all walls opaque.
struct Beam {
  BeamTruth met;
  BeamTruth opaque;
  std::optional<WallSegment> first;  ///< of opaque walls
};

/// The beams of scans all along the route.
std::vector<Beam> beams_along_route(const World& world) {
  const World opaque = as_opaque(world);
  const RobotMotion motion = drive(world.route(), {});
  const PoseAtTime pose = [&](double time) { return motion.pose(time); };
  std::vector<Beam> beams;
  for (double time = 3.0; time < motion.duration(); time += 10.0) {
    const auto met = trace_beams(world, all_round(), pose, time);
    const auto without = trace_beams(opaque, all_round(), pose, time);
    for (std::size_t k = 0; k < met.size(); ++k) {
      const std::optional<std::size_t> segment = without[k].segment;
      beams.push_back(
          {met[k], without[k], segment ? std::optional(world.segments()[*segment]) : std::nullopt});
    }
  }
  return beams;
}

/// Of these the ones that meet leaves first.
std::vector<Beam> leaves_along_route(const World& world) {
  std::vector<Beam> beams = beams_along_route(world);
  beams.erase(std::remove_if(
                  beams.begin(), beams.end(),
                  [](const Beam& beam) { return !beam.first || beam.first->surface.depth == 0.0; }),
              beams.end());
  return beams;
}

double count(const std::vector<Beam>& beams, const std::function<bool(const Beam&)>& is_counted) {
  return static_cast<double>(std::count_if(beams.begin(), beams.end(), is_counted));
}

bool is_railing(const Beam& beam) { return beam.first && beam.first->surface.passing > 0.0; }
bool is_pane(const WallSegment& segment) { return segment.surface.widest_incidence < 0.5 * kPi; }
bool goes_on(const Beam& beam) { return beam.met.segment != beam.opaque.segment; }

TEST(NewWorlds, TheirRoutesAreToursThatComeBackInMinutes) {
  for (const char* name : {"atrium", "glass", "street", "hall"}) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Route route = make_world(name, seed).route();
      EXPECT_EQ(route.waypoints.front(), route.waypoints.back()) << name;
      const double duration = drive(route, {}).duration();
      EXPECT_GT(duration, 120.0) << name;
      EXPECT_LT(duration, 300.0) << name;
    }
  }
}

TEST(NewWorlds, OthersComeBackToo) {
  for (const char* name : {"warehouse", "garage", "park", "mine", "greenhouse"}) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const std::vector<Eigen::Vector2d> points = make_world(name, seed).route().waypoints;
      EXPECT_EQ(points.front(), points.back()) << name;
      double length = 0.0;
      for (std::size_t i = 1; i < points.size(); ++i) {
        length += (points[i] - points[i - 1]).norm();
      }
      EXPECT_GT(length, 80.0) << name << ' ' << seed;
      EXPECT_LT(length, 260.0) << name << ' ' << seed;
    }
  }
}

TEST(AtriumWorld, TheRailingLetsHalfOfTheBeamsPass) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<Beam> beams = beams_along_route(make_atrium_world(seed));
    const double met = count(beams, is_railing);
    const double passed =
        count(beams, [](const Beam& beam) { return is_railing(beam) && goes_on(beam); });
    ASSERT_GT(met, 5000.0);
    EXPECT_NEAR(passed / met, 0.5, 4.0 * 0.5 / std::sqrt(met));
  }
}

TEST(AtriumWorld, BeyondTheRailingThereIsMoreToSee) {
  const World world = make_atrium_world(1);
  const std::vector<Beam> beams = beams_along_route(world);
  const double beyond = count(beams, [&](const Beam& beam) {
    return is_railing(beam) && goes_on(beam) && beam.met.segment &&
           world.segments()[*beam.met.segment].surface.passing == 0.0;
  });
  EXPECT_GT(beyond / count(beams, is_railing), 0.25);
}

TEST(AtriumWorld, ItsEndsAreRound) {
  const World world = make_atrium_world(1);
  std::set<int> directions;  // of opaque walls [degrees]
  for (const WallSegment& segment : world.segments()) {
    const Eigen::Vector2d centre(8.0, 0.0);
    const double radius = 7.6;
    if (std::abs((segment.start - centre).norm() - radius) < 1e-9 &&
        std::abs((segment.end - centre).norm() - radius) < 1e-9) {
      const Eigen::Vector2d normal = segment.normal();
      directions.insert(
          static_cast<int>(std::lround(radians_to_degrees(std::atan2(normal.y(), normal.x())))));
    }
  }
  EXPECT_GT(directions.size(), 40U);
}

TEST(GlassWorld, PanesReturnOnlyBeamsWithinTwelveDegreesOfTheirNormals) {
  const double least_cosine = std::cos(degrees_to_radians(12.0));
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const World world = make_glass_world(seed);
    const std::vector<Beam> beams = beams_along_route(world);
    double returned = 0.0;
    double passed = 0.0;
    for (const Beam& beam : beams) {
      if (beam.met.segment && is_pane(world.segments()[*beam.met.segment])) {
        EXPECT_GE(beam.met.cos_incidence, least_cosine - 1e-12);
        returned += 1.0;
      }
      if (beam.first && is_pane(*beam.first)) {
        ASSERT_EQ(goes_on(beam), beam.opaque.cos_incidence < least_cosine);
        passed += goes_on(beam) ? 1.0 : 0.0;
      }
    }
    EXPECT_GT(returned, 200.0);
    EXPECT_GT(passed, 2000.0);
  }
}

TEST(GlassWorld, FramesReturnWhateverTheAngle) {
  const World world = make_glass_world(1);
  double oblique = 0.0;
  for (const Beam& beam : beams_along_route(world)) {
    if (!beam.first || std::abs(beam.first->length() - 0.05) > 1e-9) {
      continue;  // no side of a post
    }
    EXPECT_FALSE(goes_on(beam));
    oblique += beam.opaque.cos_incidence < std::cos(degrees_to_radians(30.0)) ? 1.0 : 0.0;
  }
  EXPECT_GT(oblique, 100.0);
}

TEST(GlassWorld, MuchOfItIsGlass) {
  const World world = make_glass_world(1);
  double panes = 0.0;
  for (const WallSegment& segment : world.segments()) {
    panes += is_pane(segment) ? segment.length() : 0.0;
  }
  EXPECT_GT(panes, 60.0);
}

TEST(StreetWorld, HedgesReturnFromAnywhereInTheirDepth) {
  double returns = 0.0;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (const Beam& beam : leaves_along_route(make_street_world(seed))) {
      const double depth = beam.met.range - beam.opaque.range;
      ASSERT_GE(depth, 0.0);
      ASSERT_LE(depth, 0.3);
      EXPECT_NEAR((beam.met.end - beam.opaque.end).norm(), depth, 1e-9);
      returns += 1.0;
      sum += depth;
      sum_of_squares += depth * depth;
    }
  }
  ASSERT_GT(returns, 1000.0);
  const double mean = sum / returns;
  EXPECT_NEAR(mean, 0.15, 0.01);
  EXPECT_NEAR(std::sqrt(sum_of_squares / returns - mean * mean), 0.3 / std::sqrt(12.0), 0.01);
}

TEST(StreetWorld, MuchIsSky) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<Beam> beams = beams_along_route(make_street_world(seed));
    const double sky = count(beams, [](const Beam& beam) { return beam.met.range > 30.0; });
    EXPECT_GT(sky / static_cast<double>(beams.size()), 0.18) << seed;
    EXPECT_LT(sky / static_cast<double>(beams.size()), 0.6) << seed;
  }
}

TEST(HallWorld, IsLongerThanItMayBeSeen) {
  const World world = make_hall_world(1);
  double right = 0.0;
  for (const WallSegment& segment : world.segments()) {
    right = std::max(right, segment.end.x());
  }
  EXPECT_GE(right, 45.0);
}

TEST(HallWorld, TwelvePeopleWalkAsSeedAndTimeSay) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const World world = make_hall_world(seed);
    const World same = make_hall_world(seed);
    const World other = make_hall_world(seed + 100);
    ASSERT_EQ(world.walks().size(), 12U);
    for (std::size_t i = 0; i < world.walks().size(); ++i) {
      double way = 0.0;
      for (double time = 1327500000.0; time < 1327500060.0; time += 0.1) {
        const Eigen::Vector2d place = world.walks()[i].at(time);
        EXPECT_EQ(place, same.walks()[i].at(time));
        EXPECT_NE(place, other.walks()[i].at(time));
        way += (world.walks()[i].at(time + 0.1) - place).norm();
      }
      EXPECT_GT(way / 60.0, 0.5);
      EXPECT_LT(way / 60.0, 1.51);
    }
  }
}

TEST(HallWorld, PeopleAreSeenWhereTheyAreAndNowhereElse) {
  const World world = make_hall_world(2);
  const LaserOptions laser = all_round();
  const PoseAtTime pose = [](double /*time*/) { return Pose2{24.0, 6.0, 0.0}; };
  std::set<std::size_t> seen;
  for (double time = 0.0; time < 60.0; time += 5.0) {
    for (const BeamTruth& beam : trace_beams(world, laser, pose, time)) {
      const std::optional<std::size_t> walk =
          beam.segment ? world.segments()[*beam.segment].surface.walk : std::nullopt;
      if (walk) {
        seen.insert(*walk);
        EXPECT_LE((beam.end - world.walks()[*walk].at(time)).norm(), 0.25 + 1e-9);
      }
    }
  }
  EXPECT_GT(seen.size(), 6U);
}

TEST(HallWorld, PeopleKeepHalfAMetreFromTheRoute) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const World world = make_hall_world(seed);
    const std::vector<Eigen::Vector2d>& points = world.route().waypoints;
    for (const Walk& walk : world.walks()) {
      for (double time = 0.0; time < 60.0; time += 0.1) {
        for (std::size_t i = 1; i < points.size(); ++i) {
          ASSERT_GT(distance(WallSegment{points[i - 1], points[i]}, walk.at(time)), 0.75 - 1e-9);
        }
      }
    }
  }
}

TEST(HallWorld, LegsAndPillarsAreThin) {
  const World world = make_hall_world(1);
  const auto legs = std::count_if(world.segments().begin(), world.segments().end(),
                                  [](const WallSegment& segment) { return segment.is_table; });
  EXPECT_GT(legs, 4 * 20 * 5);
  for (const WallSegment& segment : world.segments()) {
    if (segment.is_table) {
      ASSERT_LE(segment.length(), 0.05 + 1e-9);
    }
  }
}

/// Outlines of four sides that lie within these lengths [m].
int count_boxes(const World& world, double least, double most) {
  const std::vector<WallSegment>& segments = world.segments();
  int boxes = 0;
  for (std::size_t i = 0; i + 3 < segments.size(); ++i) {
    const auto is_side = [&](std::size_t k) {
      const double length = segments[i + k].length();
      return length >= least && length <= most;
    };
    if (segments[i].start == segments[i + 3].end && is_side(0) && is_side(1) && is_side(2) &&
        is_side(3)) {
      ++boxes;
    }
  }
  return boxes;
}

TEST(WarehouseWorld, ThreePalletsOfTenAreMissing) {
  constexpr double kPlaces = 5 * 2 * 12 * 2;
  double pallets = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    pallets += count_boxes(make_warehouse_world(seed), 0.7, 0.95);
  }
  EXPECT_NEAR(pallets / static_cast<double>(kSeeds), 0.7 * kPlaces, 0.04 * kPlaces);
}

TEST(GarageWorld, CarsStandInThreeBaysOfFive) {
  constexpr double kBays = 4 * 20;
  double cars = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    cars += count_boxes(make_garage_world(seed), 1.6, 4.6);
  }
  EXPECT_NEAR(cars / static_cast<double>(kSeeds), 0.6 * kBays, 0.08 * kBays);
}

TEST(ParkWorld, NothingIsLongerThanABench) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const World world = make_park_world(seed);
    for (const WallSegment& segment : world.segments()) {
      ASSERT_LE(segment.length(), 1.6 + 1e-9);
    }
    EXPECT_GT(world.things().size(), 100U);
  }
}

TEST(MineWorld, TheTunnelIsNarrowAndShutOnBothSides) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const World world = make_mine_world(seed);
    const Eigen::Vector2d place = world.route().waypoints[3];
    const PoseAtTime pose = [&](double /*time*/) { return Pose2{place.x(), place.y(), 0.0}; };
    for (const BeamTruth& beam : trace_beams(world, all_round(), pose, 0.0)) {
      EXPECT_TRUE(beam.segment);
    }
    for (const Eigen::Vector2d& point : world.route().waypoints) {
      double nearest = 100.0;
      for (const WallSegment& segment : world.segments()) {
        nearest = std::min(nearest, distance(segment, point));
      }
      EXPECT_GT(nearest, 0.7) << seed;
      EXPECT_LT(nearest, 1.7 + 0.5) << seed;
    }
  }
}

TEST(GreenhouseWorld, LeavesReturnWithinTheirDepthAndEachFaceLetsAFifthPass) {
  double met = 0.0;
  double passed = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (const Beam& beam : leaves_along_route(make_greenhouse_world(seed))) {
      met += 1.0;
      if (goes_on(beam)) {
        passed += 1.0;
      } else {
        ASSERT_LE(beam.met.range - beam.opaque.range, 0.25 + 1e-9);
      }
    }
  }
  ASSERT_GT(met, 1000.0);
  EXPECT_NEAR(passed / met, 0.2, 0.01);
}

}  // namespace
}  // namespace matchbox_slam
