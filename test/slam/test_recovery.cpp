// Drives on which something goes wrong: the robot is found again, and nothing wrong was mapped.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/fault.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

/// What became of a drive through rooms.
struct Drive {
  double end_error = 0.0;       ///< [m]
  double worst_key_scan = 0.0;  ///< [m]
  std::size_t scans = 0;
  std::map<TrackingState, std::size_t> states;
  std::size_t parts_apart = 0;
  ScanOutcome last;
};

SimulatedRun drive_with(const std::string& fault) {
  SimulationOptions options;
  options.laser.scan_rate = 10.0;
  options.laser.beams = 520;
  if (!fault.empty()) {
    options.faults = {parse_fault(fault)};
  }
  const World world = make_world("rooms", 3);
  return simulate_run(world, world.route(), options, 3);
}

double distance(const Pose2& a, const Pose2& b) {
  return (a.translation() - b.translation()).norm();
}

Drive drive(const std::string& fault, const std::shared_ptr<const ScanMatcher>& matcher) {
  const SimulatedRun run = drive_with(fault);
  SlamEngine engine(EngineOptions{}, matcher, 1, run.world_from_base.front());
  Drive result;
  std::map<double, Pose2> truth;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    result.last = engine.process(scan_input(run, i));
    truth[result.last.stamp] = run.world_from_base[i];
    ++result.states[result.last.state];
  }
  result.scans = run.scans.size();
  result.end_error = distance(result.last.map_from_base, run.world_from_base.back());
  for (const PlacedScan& key : engine.key_scans().all()) {
    result.worst_key_scan =
        std::max(result.worst_key_scan,
                 distance(key.map_from_base, truth.at(key.scan->measured()->scan.stamp)));
  }
  result.parts_apart = engine.parts_apart();
  return result;
}

const std::shared_ptr<const ScanMatcher> kOlson = std::make_shared<OlsonMatcher>();
const std::shared_ptr<const ScanMatcher> kMonteCarlo = std::make_shared<MonteCarloMatcher>();

/// Ends where it should, with a right map.
void expect_unharmed(const Drive& drive) {
  EXPECT_LT(drive.end_error, 0.005);
  EXPECT_LT(drive.worst_key_scan, 0.01);
  EXPECT_EQ(drive.parts_apart, 0U);
  EXPECT_EQ(drive.last.state, TrackingState::kTracking);
}

TEST(Recovery, AHealthyDriveIsNeverInDoubt) {
  const Drive healthy = drive("", kOlson);
  expect_unharmed(healthy);
  EXPECT_EQ(healthy.states.at(TrackingState::kTracking), healthy.scans);
}

TEST(Recovery, OdometryThatJumpsAMetreDoesNoHarm) {
  expect_unharmed(drive("jump:60::1", kOlson));
  expect_unharmed(drive("jump:60::1", kMonteCarlo));
}

TEST(Recovery, OdometryThatStandsStillDoesNoHarm) {
  expect_unharmed(drive("freeze:60:3", kOlson));
  expect_unharmed(drive("encoders:60:10", kMonteCarlo));
}

TEST(Recovery, OdometryThatMissesATurnDoesNoHarm) {
  expect_unharmed(drive("turn_jump:60::1", kOlson));
  expect_unharmed(drive("turn_jump:60::1", kMonteCarlo));
}

TEST(Recovery, ARobotThatIsCarriedAwayIsFound) {
  for (const auto& matcher : {kOlson, kMonteCarlo}) {
    const Drive carried = drive("kidnap:60:2:2", matcher);
    EXPECT_GT(carried.states.count(TrackingState::kLost), 0U);
    EXPECT_EQ(carried.last.state, TrackingState::kTracking);
    EXPECT_EQ(carried.parts_apart, 0U);
    EXPECT_LT(carried.end_error, 0.015);     // 0.012
    EXPECT_LT(carried.worst_key_scan, 0.2);  // 0.150, of the first scan on the way elsewhere
  }
}

TEST(Recovery, WithoutDoubtATurnThatIsMissedRuinsTheMap) {
  const SimulatedRun run = drive_with("turn_jump:60::1");
  EngineOptions options;
  options.doubt.enabled = false;
  SlamEngine engine(options, kOlson, 1, run.world_from_base.front());
  ScanOutcome outcome;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    outcome = engine.process(scan_input(run, i));
  }
  EXPECT_GT(distance(outcome.map_from_base, run.world_from_base.back()), 0.3);
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
