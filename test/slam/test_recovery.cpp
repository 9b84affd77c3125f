// Of slam/relocalizer.hpp: drives on which something goes wrong; the robot is found again, and
// nothing wrong was mapped.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/fault.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/matchers.hpp"
#include "slam/place_index.hpp"
#include "slam/pose_distance.hpp"
#include "slam/relocalizer.hpp"

namespace matchbox_slam {
namespace {

/// What became of a drive.
struct DriveResult {
  double end_error = 0.0;       ///< [m]
  double worst_error = 0.0;     ///< [m] of all scans
  double worst_sigma = 0.0;     ///< [m], largest standard deviation of a scan's position
  double worst_key_scan = 0.0;  ///< [m]
  std::size_t scans = 0;
  std::map<TrackingState, std::size_t> states;
  std::size_t disconnected_components = 0;
  ScanOutcome last;
};

SimulatedRun simulate_in(const std::string& world_name, const SimulationOptions& options,
                         std::uint64_t seed) {
  const World world = make_world(world_name, seed);
  return simulate_run(world, world.route(), options, seed);
}

SimulatedRun drive_with(const std::string& fault, std::uint64_t seed = 3, int beams = 520) {
  SimulationOptions options;
  options.laser.scan_rate = 10.0;
  options.laser.beams = beams;
  if (!fault.empty()) {
    options.faults = {parse_fault(fault)};
  }
  return simulate_in("rooms", options, seed);
}

DriveResult drive(const SimulatedRun& run, const std::shared_ptr<const ScanMatcher>& matcher,
                  const EngineOptions& options = {}) {
  SlamEngine engine(options, matcher, 1, run.world_from_base.front());
  DriveResult result;
  std::map<double, Pose2> truth;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    result.last = engine.process(scan_input(run, i));
    truth[result.last.stamp] = run.world_from_base[i];
    ++result.states[result.last.state];
    result.worst_error =
        std::max(result.worst_error, distance(result.last.map_from_base, run.world_from_base[i]));
    result.worst_sigma = std::max(result.worst_sigma,
                                  std::sqrt(result.last.covariance.topLeftCorner<2, 2>().trace()));
  }
  result.scans = run.scans.size();
  result.end_error = distance(result.last.map_from_base, run.world_from_base.back());
  for (const PlacedScan& key : engine.key_scans().all()) {
    result.worst_key_scan =
        std::max(result.worst_key_scan,
                 distance(key.map_from_base, truth.at(key.scan->measured()->scan.stamp)));
  }
  result.disconnected_components = engine.disconnected_components();
  return result;
}

DriveResult drive(const std::string& fault, const std::shared_ptr<const ScanMatcher>& matcher) {
  return drive(drive_with(fault), matcher);
}

/// Ends where it should, with a right map.
void expect_unharmed(const DriveResult& drive) {
  EXPECT_LT(drive.end_error, 0.0065);      // 0.0051
  EXPECT_LT(drive.worst_key_scan, 0.012);  // 0.0109
  EXPECT_EQ(drive.disconnected_components, 0U);
  EXPECT_EQ(drive.last.state, TrackingState::kTracking);
}

void expect_never_in_doubt(const DriveResult& drive) {
  expect_unharmed(drive);
  EXPECT_EQ(drive.states.at(TrackingState::kTracking), drive.scans);
}

TEST(Recovery, AHealthyDriveIsNeverInDoubt) { expect_never_in_doubt(drive("", kOlson)); }

TEST(Recovery, OdometryThatJumpsAMetreDoesNoHarm) {
  expect_unharmed(drive("jump:60::1", kOlson));
  expect_unharmed(drive("jump:60::1", kMonteCarlo));
}

TEST(Recovery, OdometryThatStandsStillDoesNoHarm) {
  expect_unharmed(drive("freeze:60:3", kOlson));
  expect_unharmed(drive("encoders:60:10", kMonteCarlo));
}

/// After five seconds it is where it would have been, 2.3 m on, farther than a search reaches, in a
/// doorway, where the few beams fit the wrong place halfway.
TEST(Recovery, OdometryThatCatchesUpDoesNoHarm) {
  SimulationOptions options;
  options.laser.scan_rate = 10.0;
  options.laser.beams = 181;
  options.laser.field_of_view = 2.0 * kPi;
  options.laser.range_max = 15.0;
  options.laser.range_noise = 0.002;
  options.time.duration = 90.0;
  options.faults = {parse_fault("freeze:74.5:4.81")};
  expect_never_in_doubt(drive(simulate_in("rooms", options, 1055), kOlson));
}

/// Where scans are rare, a robot may turn by a radian in a step.
TEST(Recovery, OdometryThatTurnsByARadianDoesNoHarmWhereScansAreRare) {
  SimulationOptions options;
  options.laser.scan_rate = 5.0;
  options.laser.beams = 520;
  options.faults = {parse_fault("turn_jump:75::1")};
  expect_unharmed(drive(simulate_in("rooms", options, 3), kOlson));
}

/// Whose ends are out of sight: what the robot has just drawn of it lies as wrong as the robot.
TEST(Recovery, InACorridorThatHoldsNothingTheWaySinceTheLastKeyScanCounts) {
  SimulationOptions options;
  options.laser.range_max = 6.0;
  options.time.duration = 60.0;
  const DriveResult driven = drive(simulate_in("corridor", options, 1), kOlson);
  EXPECT_LT(driven.worst_sigma, 0.6);  // [m], 0.40; 2.4 if all of the way counts
  EXPECT_LT(driven.worst_error, 0.5);  // [m], 0.33, as odometry is
}

/// Few beams: a far hit of the side wall, always of the same beam, lies beside the front of what
/// stands out there, and held the robot where it was while it drove on.
TEST(Recovery, ACorridorDoesNotHoldARobotThatDrives) {
  SimulationOptions options;
  options.laser.beams = 181;
  options.laser.field_of_view = 3.14;
  options.laser.range_max = 30.0;
  options.laser.scan_rate = 20.0;
  options.drive.speed = 0.5;
  options.time.duration = 60.0;
  const DriveResult driven = drive(simulate_in("campus", options, 150), kOlson);
  EXPECT_LT(driven.worst_error, 0.11);  // [m], 0.100; 0.66 where it is held, 2.9 after four minutes
}

/// At 8 m/s: one scan on the way fits somewhere, with half of the usual score.
TEST(Recovery, ARobotThatIsCarriedFastDrawsNothingOnItsWay) {
  const DriveResult carried = drive(drive_with("kidnap:random:2:2", 118, 1040), kOlson);
  EXPECT_LT(carried.worst_key_scan, 0.04);  // [m], 0.027; 0.77 where such a match is believed
  EXPECT_LT(carried.end_error, 0.005);      // [m], 0.003
}

TEST(Recovery, AMatchInDoubtTeachesNothingOfOdometry) {
  const SimulatedRun run = drive_with("jump:random::1");
  SlamEngine engine(EngineOptions{}, kOlson, 1, run.world_from_base.front());
  double before = 1.0;
  double least = 1.0;
  std::size_t doubtful = 0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const ScanOutcome outcome = engine.process(scan_input(run, i));
    const double now = engine.snapshot().motion.noise_scale.translation;
    if (outcome.certainty == Certainty::kOvertaken || outcome.state == TrackingState::kDoubt) {
      ++doubtful;
      EXPECT_EQ(now, before) << i;
    }
    before = now;
    least = std::min(least, now);
  }
  EXPECT_GT(doubtful, 0U);
  EXPECT_LT(least, 0.5);
}

TEST(Recovery, AllHypothesesGoOnWhereNothingIsInReach) {
  SimulatedRun run = drive_with("jump:random::1");
  SlamEngine engine(EngineOptions{}, kOlson, 1, run.world_from_base.front());
  std::size_t i = 0;
  while (engine.likely_poses().size() < 2) {
    ASSERT_LT(i, run.scans.size()) << "never in doubt";
    static_cast<void>(engine.process(scan_input(run, i++)));
  }
  const auto apart = [&engine] {
    const std::vector<WeightedPose> poses = engine.likely_poses();
    return poses.size() < 2 ? Pose2{} : poses[1].map_from_base * poses[0].map_from_base.inverse();
  };
  const Pose2 before = apart();
  const Pose2 from = engine.likely_poses().front().map_from_base;
  for (const std::size_t end = i + 20; i < end; ++i) {
    std::fill(run.scans[i].ranges.begin(), run.scans[i].ranges.end(),
              std::numeric_limits<float>::infinity());
    ASSERT_EQ(engine.process(scan_input(run, i)).match.status, MatchStatus::kRejectedTooFewPoints);
  }
  EXPECT_GT(distance(engine.likely_poses().front().map_from_base, from), 0.5);
  EXPECT_LT(distance(apart(), before), 1e-9);
}

TEST(Recovery, OdometryThatMissesATurnDoesNoHarm) {
  expect_unharmed(drive("turn_jump:60::1", kOlson));
  expect_unharmed(drive("turn_jump:60::1", kMonteCarlo));
}

TEST(Recovery, ARobotThatIsCarriedAwayIsFound) {
  for (const auto& matcher : {kOlson, kMonteCarlo}) {
    const DriveResult carried = drive("kidnap:60:2:2", matcher);
    EXPECT_GT(carried.states.count(TrackingState::kLost), 0U);
    EXPECT_EQ(carried.last.state, TrackingState::kTracking);
    EXPECT_EQ(carried.disconnected_components, 0U);
    EXPECT_LT(carried.end_error, 0.015);     // 0.012
    EXPECT_LT(carried.worst_key_scan, 0.2);  // 0.150, of the first scan on the way elsewhere
  }
}

TEST(Recovery, ALaserThatIsCoveredWhileItEntersARoomDoesNoHarm) {
  const DriveResult covered = drive(drive_with("covered:random:5:0.8", 8, 1040), kOlson);
  EXPECT_LT(covered.end_error, 0.0065);
  EXPECT_LT(covered.worst_key_scan, 0.06);  // 0.052
}

/// A room of 5 m by 4 m with things in it. Its door, open or shut, leads to a corridor, or to a
/// hall.
World room_beside(bool is_hall, bool is_shut = false) {
  const double x = is_hall ? 12.0 : 7.0;  // of the wall across the door
  std::vector<WallSegment> walls{{{0, 0}, {5, 0}},   {{5, 0}, {5, 0.5}},   {{5, 0.8}, {5, 4}},
                                 {{5, 4}, {0, 4}},   {{0, 4}, {0, 0}},     {{0, 2.5}, {0.6, 2.5}},
                                 {{3, 4}, {3, 3.6}}, {{3, 3.6}, {4, 3.6}}, {{1.5, 0}, {1.5, 0.4}}};
  walls.push_back({{x, -6}, {x, 8}});
  walls.push_back({{5, -6}, {x, -6}});
  walls.push_back({{5, 8}, {x, 8}});
  walls.push_back({{5, -6}, {5, 0}});
  walls.push_back({{5, 4}, {5, 8}});
  if (is_shut) {
    walls.push_back({{5, 0.5}, {5, 0.8}});
  }
  return {walls, {}};
}

/// What was seen in the room, through its door and beside it.
MapComponent seen_of(const World& world) {
  const EngineOptions options;
  MapComponent component{SlamMap(options.map, options.field), {}, {}, 0.0};
  const LaserOptions laser;
  std::vector<Pose2> places;
  for (double x = 1.0; x < 6.5; x += 0.5) {
    places.push_back({x, 0.65, 0.0});
    places.push_back({x, 0.65, kPi});
  }
  for (double y = 1.5; y < 5.0; y += 0.5) {
    places.push_back({6.0, y, 0.5 * kPi});
  }
  for (const Pose2& place : places) {
    component.key_scans.add(
        MeasuredScan{ideal_scan(world, laser, place), laser.base_from_laser(), {}, {}}, 0, place);
    insert_scan(*component.key_scans.all().back().scan->points(), place, options.map,
                component.map);
  }
  return component;
}

/// Whether a robot that goes round the room, or stands in it, after it has seen what the component
/// holds, is taken to be in the other one.
bool is_found(MapComponent map, MapComponent active, const World& room, bool stands = false,
              const Pose2& parent_from_component = {20.0, 0.0, 0.0}) {
  active.parent_from_component = parent_from_component;  // by odometry
  std::vector<MapComponent> components{std::move(map), std::move(active)};
  const PlaceIndex index(components, 1);
  const EngineOptions options;
  const LaserOptions laser;
  PlaceSearch search;
  for (int i = 1; i < 60; ++i) {
    const double turn = stands ? 0.3 : 0.3 * i;
    const Pose2 base{2.2 + std::cos(turn), 2.0 + std::sin(turn), turn};
    if (!stands) {
      components[1].key_scans.add(
          MeasuredScan{ideal_scan(room, laser, base, 0.2 * i), laser.base_from_laser(), {}, {}}, 0,
          base);
    }
    const auto found = search_places(base, components, 1, index, options, search);
    if (found) {
      EXPECT_LT(distance(found->component_from_active, {}), 0.02);
      return true;
    }
  }
  return false;
}

TEST(Recovery, AnEqualRoomIsToldByWhatLiesAroundIt) {
  const World corridor = room_beside(false);
  const World hall = room_beside(true);
  EXPECT_TRUE(is_found(seen_of(corridor), seen_of(corridor), corridor));
  EXPECT_FALSE(is_found(seen_of(corridor), seen_of(hall), hall));
}

TEST(Recovery, ARobotThatStandsIsFoundByWhatItSawOnItsWay) {
  const World room = room_beside(false);
  EXPECT_TRUE(is_found(seen_of(room), seen_of(room), room, true));
  EXPECT_FALSE(is_found(seen_of(room), seen_of(room_beside(true)), room, true));
}

/// What a robot that stands says is one sample of evidence, however often it is searched for: its
/// place is named, with odds that leave room for places like it that are not mapped, and not taken.
TEST(Recovery, ARobotThatStandsHasItsPlaceNamedByOneScanAndIsNotFoundByIt) {
  const World room = room_beside(false);
  const EngineOptions options;
  const LaserOptions laser;
  const Pose2 base{2.5, 1.5, 0.7};
  MapComponent active{SlamMap(options.map, options.field), {}, {}, 0.0};
  active.parent_from_component = Pose2{20.0, 0.0, 0.0};
  active.key_scans.add(
      MeasuredScan{ideal_scan(room, laser, base, 0.2), laser.base_from_laser(), {}, {}}, 0, base);
  const std::vector<MapComponent> components{seen_of(room), active};
  const PlaceIndex index(components, 1);
  PlaceSearch search;
  for (int i = 1; i < 60; ++i) {
    EXPECT_FALSE(search_places(base, components, 1, index, options, search));
  }
  ASSERT_FALSE(search.hypotheses.empty());
  EXPECT_LT(distance(search.hypotheses.front().component_from_active, {}), 0.02);
  EXPECT_GT(search.hypotheses.front().log_odds, 1.0);
  EXPECT_LT(search.hypotheses.front().log_odds, 6.0);
}

/// A robot that was carried 1.6 m counted as found in a corner that was much like its own.
TEST(Recovery, WhereOdometrySaysAnEqualRoomIsToldByWhatLiesAroundItToo) {
  const World corridor = room_beside(false);
  const World hall = room_beside(true);
  const Pose2 near{0.2, 0.1, 0.05};
  EXPECT_TRUE(is_found(seen_of(corridor), seen_of(corridor), corridor, false, near));
  EXPECT_FALSE(is_found(seen_of(corridor), seen_of(hall), hall, false, near));
}

/// What is looked for, in a map of two components, by a robot that goes round the room: whether it
/// is found, and in how many places it may be at the end.
struct TwoComponents {
  bool is_found = false;
  PlaceSearch search;
};

TwoComponents search_two_components(const World& first, const World& second,
                                    PlaceSearch search = {}) {
  const World room = room_beside(false);
  MapComponent active = seen_of(room);
  active.parent_from_component = Pose2{20.0, 0.0, 0.0};  // by odometry far away
  std::vector<MapComponent> components{seen_of(first), seen_of(second), active};
  const PlaceIndex index(components, 2);
  const EngineOptions options;
  const LaserOptions laser;
  TwoComponents result{false, std::move(search)};
  for (int i = 1; i < 60 && !result.is_found; ++i) {
    const Pose2 base{2.2 + std::cos(0.3 * i), 2.0 + std::sin(0.3 * i), 0.3 * i};
    components[2].key_scans.add(
        MeasuredScan{ideal_scan(room, laser, base, 0.2 * i), laser.base_from_laser(), {}, {}}, 0,
        base);
    for (int times = 0; times < 2; ++times) {  // what it saw before is asked, too
      result.is_found =
          result.is_found ||
          search_places(base, components, 2, index, options, result.search).has_value();
    }
  }
  return result;
}

/// A map of two components that are alike, one found long before the other.
TEST(Recovery, APlaceThatWasFoundFirstIsNotTheOneForIt) {
  PlaceSearch search;
  search.hypotheses.push_back({0, Pose2{}, 1000.0, 0.0});
  const TwoComponents alike = search_two_components(room_beside(false), room_beside(false), search);
  EXPECT_FALSE(alike.is_found);
  EXPECT_GE(alike.search.hypotheses.size(), 2U);
}

/// Scans taken on the threshold of a door that was shut see through it: at most a quarter of them.
TEST(Recovery, APlaceWhoseDoorIsShutByNowMayBeTheRightOne) {
  const TwoComponents alike = search_two_components(room_beside(false), room_beside(false, true));
  EXPECT_FALSE(alike.is_found);
  EXPECT_TRUE(search_two_components(room_beside(false), room_beside(true)).is_found);
}

/// It sees nothing within a wall, and is carried on when it counts as lost.
TEST(Recovery, AScanThatNothingConfirmedDoesNotBeginAMap) {
  const DriveResult carried = drive(drive_with("kidnap:random:2:2", 2133, 1040), kOlson);
  EXPECT_EQ(carried.last.state, TrackingState::kTracking);
  EXPECT_LT(carried.end_error, 0.005);
  EXPECT_LT(carried.worst_key_scan, 0.01);  // 1.1 where walls are taken for their other side
}

/// It is carried on at 8 m/s when it counts as lost, so that its first component is torn.
TEST(Recovery, WhatWasSeenWhileItWasCarriedIsNotJoined) {
  const DriveResult carried = drive(drive_with("kidnap:random:2:2", 47, 1040), kOlson);
  EXPECT_EQ(carried.last.state, TrackingState::kTracking);
  EXPECT_EQ(carried.disconnected_components, 0U);
  EXPECT_LT(carried.end_error, 0.005);
  EXPECT_LT(carried.worst_key_scan, 0.01);  // 3.0 if all is inserted
}

TEST(Recovery, WithoutHypothesesARobotThatIsCarriedRuinsTheMap) {
  EngineOptions options;
  options.hypotheses.enabled = false;
  EXPECT_GT(drive(drive_with("kidnap:60:2:2"), kOlson, options).end_error, 0.3);
}

TEST(Recovery, APoseThatIsToldFindsALostRobot) {
  const SimulatedRun run = drive_with("kidnap:60:2:2");
  SlamEngine engine(EngineOptions{}, kOlson, 1, run.world_from_base.front());
  ScanOutcome outcome;
  std::size_t i = 0;
  for (; run.scans[i].stamp < run.scans.front().stamp + 63.0; ++i) {  // it stands again
    outcome = engine.process(scan_input(run, i));
  }
  ASSERT_EQ(engine.state(), TrackingState::kLost);
  EXPECT_GT(outcome.covariance(0, 0), 25.0) << "it may be anywhere";
  engine.set_pose(run.world_from_base[i - 1], 0.01 * Eigen::Matrix3d::Identity());
  outcome = engine.process(scan_input(run, i));
  EXPECT_EQ(outcome.state, TrackingState::kTracking);
  EXPECT_LT(distance(outcome.map_from_base, run.world_from_base[i]), 0.01);
}

}  // namespace
}  // namespace matchbox_slam
