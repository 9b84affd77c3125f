// Of slam/slam_engine.hpp: predictions, and poses that it is told.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "simulation/world_changes.hpp"
#include "slam/engine_runs.hpp"
#include "slam/map_equality.hpp"
#include "slam/pose_distance.hpp"

namespace matchbox_slam {
namespace {

TEST(SlamEngine, StartsWhereItIsTold) {
  const SimulatedRun run = drive_through("rooms", 1.0, 3);
  SlamEngine engine({}, monte_carlo(), 1, {10.0, -20.0, 3.0});
  const ScanOutcome first = engine.process(scan_input(run, 0));
  EXPECT_EQ(first.map_from_base, (Pose2{10.0, -20.0, 3.0}));
  EXPECT_EQ(first.predicted_map_from_base, first.map_from_base);
  EXPECT_EQ(first.match.status, MatchStatus::kRejectedNoReference);
  EXPECT_TRUE(first.inserted);
  EXPECT_EQ(first.stamp, run.scans[0].stamp);
}

TEST(SlamEngine, ARejectedMatchFallsBackToOdometryAndLeavesTheMap) {
  const SimulatedRun run = drive_through("rooms", 10.0, 3);
  SlamEngine engine = make_engine(run, std::make_shared<RejectingMatcher>());
  EngineOptions options;
  options.hypotheses.enabled = false;  // nothing looks again
  engine.set_options(options);
  engine.process(scan_input(run, 0));
  const SlamMap after_first = engine.map();
  const Pose2 map_from_odom =
      run.world_from_base.front() * scan_input(run, 0).odometry->odom_from_base.inverse();
  for (std::size_t i = 1; i < run.scans.size(); ++i) {
    const ScanOutcome outcome = engine.process(scan_input(run, i));
    ASSERT_FALSE(outcome.inserted);
    ASSERT_EQ(outcome.map_from_base, outcome.predicted_map_from_base);
    const Pose2 expected = map_from_odom * *outcome.odom_from_base;
    ASSERT_LT((outcome.map_from_base.translation() - expected.translation()).norm(), 1e-9);
    ASSERT_GT(outcome.covariance.trace(), 0.0);
  }
  EXPECT_TRUE(same_map(after_first, engine.map()));
  EXPECT_EQ(engine.key_scans().size(), 1U);
}

TEST(SlamEngine, RecoversAfterRejectedMatches) {
  const SimulatedRun run = drive_through("rooms", 12.0, 3);
  SlamEngine engine = make_engine(run);
  Pose2 last;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    if (i == 100) {
      engine.set_matcher(std::make_shared<RejectingMatcher>());
    } else if (i == 120) {
      engine.set_matcher(monte_carlo());
    }
    last = engine.process(scan_input(run, i)).map_from_base;
  }
  EXPECT_LT((last.translation() - run.world_from_base.back().translation()).norm(), 0.02);
}

/// Finds each scan far from where it is.
class AstrayMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    MatchResult result = monte_carlo()->match(problem);
    result.map_from_base = displaced(result.map_from_base, {0.4, -0.3, 0.05});
    return result;
  }
};

TEST(SlamEngine, AMatchElsewhereHasToBeLikelierThanTheMotion) {
  const SimulatedRun run = drive_through("rooms", 12.0, 3);
  SlamEngine engine = make_engine(run);
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const bool is_astray = i == 100;
    engine.set_matcher(is_astray ? std::make_shared<AstrayMatcher>() : monte_carlo());
    const ScanOutcome outcome = engine.process(scan_input(run, i));
    ASSERT_EQ(outcome.match.status == MatchStatus::kRejectedUnexpected, is_astray) << i;
    ASSERT_LT(distance(outcome.map_from_base, run.world_from_base[i]), 0.03) << i;
    ASSERT_EQ(outcome.state, TrackingState::kTracking) << i;
  }
}

/// Matches each scan beside where it is predicted.
class BesideMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    MatchResult result = rejected(problem, MatchStatus::kAccepted);
    result.map_from_base = displaced(problem.predicted_map_from_base, {0.4, -0.3, 0.05});
    result.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    result.score = 0.8;
    return result;
  }
};

TEST(SlamEngine, WhatWasMatchedBesideTheMotionIsNotDrawnOnNewGround) {
  const SimulatedRun run = drive_through("rooms", 2.0, 3);
  SlamEngine engine = make_engine(run);
  engine.process(scan_input(run, 0));
  engine.set_matcher(std::make_shared<BesideMatcher>());
  engine.set_pose({500.0, 0.0, 0.0}, 1e-6 * Eigen::Matrix3d::Identity());
  const ScanOutcome outcome = engine.process(scan_input(run, 1));
  EXPECT_EQ(outcome.match.status, MatchStatus::kRejectedUnexpected);
  EXPECT_EQ(outcome.map_from_base, outcome.predicted_map_from_base);
  EXPECT_EQ(outcome.certainty, Certainty::kUnmatched);
  EXPECT_FALSE(outcome.inserted);
}

TEST(SlamEngine, GoesOnFromThePoseThatItIsTold) {
  const SimulatedRun run = drive_through("rooms", 2.0, 3);
  SlamEngine engine = make_engine(run);
  engine.process(scan_input(run, 0));
  const Pose2 told = run.world_from_base[0] * Pose2{0.15, -0.1, 0.08};
  engine.set_pose(told, Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal());
  const ScanOutcome outcome = engine.process(scan_input(run, 1));
  // The robot still rests: the prediction is what was told, and the match mends it.
  EXPECT_LT((told.inverse() * outcome.predicted_map_from_base).translation().norm(), 1e-3);
  EXPECT_TRUE(outcome.match.accepted());
  EXPECT_LT((run.world_from_base[1].inverse() * outcome.map_from_base).translation().norm(), 0.005);
}

TEST(SlamEngine, StartsAtThePoseThatItIsToldBeforeTheFirstScan) {
  const SimulatedRun run = drive_through("rooms", 1.0, 3);
  SlamEngine engine = make_engine(run);
  const Pose2 told{3.0, -2.0, 1.0};
  engine.set_pose(told, Eigen::Matrix3d::Zero());
  EXPECT_EQ(engine.process(scan_input(run, 0)).map_from_base, told);
}

TEST(SlamEngine, BeforeTheFirstScanItTakesTheUncertaintyOfItsPoseToo) {
  const SimulatedRun run = drive_through("rooms", 12.0, 5);
  SlamEngine mapped = make_engine(run);
  process(run, mapped);
  // The robot is started 0.2 m from where it is told to be, in a map that is there already.
  SlamEngine engine = make_engine(run);
  EngineState start = mapped.snapshot();
  const Pose2 told = run.world_from_base.front() * Pose2{0.2, -0.1, 0.1};
  start.begin_anew(told, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
  engine.start_from(start);
  const ScanOutcome outcome = engine.process(scan_input(run, 0));
  EXPECT_LT(
      (outcome.map_from_base.translation() - run.world_from_base.front().translation()).norm(),
      0.01);
  // Told with certainty, it stays there.
  SlamEngine certain = make_engine(run);
  start.begin_anew(told, Eigen::Matrix3d::Zero());
  certain.start_from(start);
  EXPECT_EQ(certain.process(scan_input(run, 0)).map_from_base, told);
}

EngineOptions without_updates() {
  EngineOptions options;
  options.slam.update_map = false;
  return options;
}

/// A drive in the map of another one, told where it begins. The map stays as it is.
std::vector<ScanOutcome> localised(const SimulatedRun& run, SlamEngine& mapped) {
  SlamEngine engine = make_engine(run, monte_carlo(), without_updates());
  EngineState start = mapped.snapshot();
  start.begin_anew(run.world_from_base.front(), start.motion.covariance);
  engine.start_from(start);
  std::vector<ScanOutcome> outcomes = process(run, engine);
  EXPECT_TRUE(std::none_of(outcomes.begin(), outcomes.end(),
                           [](const ScanOutcome& outcome) { return outcome.inserted; }));
  EXPECT_TRUE(same_map(engine.map(), mapped.map()));
  EXPECT_EQ(engine.key_scans().size(), mapped.key_scans().size());
  return outcomes;
}

TEST(SlamEngine, WithoutUpdatesTheMapOnlyTellsWhereTheRobotIs) {
  const SimulatedRun run = drive_through("rooms", 12.0, 5);
  SlamEngine mapped = make_engine(run);
  process(run, mapped);
  EXPECT_LT(rms_error(run, localised(run, mapped)), 0.005);
  // Without a map there is nothing to tell, and none is made.
  SlamEngine empty = make_engine(run, monte_carlo(), without_updates());
  EXPECT_EQ(process(run, empty).back().match.status, MatchStatus::kRejectedNoReference);
  EXPECT_TRUE(empty.map().field.empty());
}

// The robot knows each thing that stands elsewhere once it has seen it.
TEST(SlamEngine, WithoutUpdatesItKeepsItsPlaceWhereAllOfTheFurnitureStandsElsewhere) {
  const World before = make_world("rooms", 31);
  SimulationOptions drive;
  drive.laser.beams = 180;
  drive.time.duration = 60.0;
  const SimulatedRun first = simulate_run(before, before.route(), drive, 31);
  SlamEngine mapped = make_engine(first);
  process(first, mapped);
  WorldChangeOptions changes;
  changes.moved = 1.0;
  const ChangedWorld now = changed(before, changes);
  ASSERT_GT(now.moved, 40U);
  const SimulatedRun second = simulate_run(now.world, before.route(), drive, 32);
  const std::vector<ScanOutcome> outcomes = localised(second, mapped);
  for (const ScanOutcome& outcome : outcomes) {
    ASSERT_EQ(outcome.state, TrackingState::kTracking) << outcome.stamp;
  }
  EXPECT_LT(rms_error(second, outcomes), 0.006);
}

}  // namespace
}  // namespace matchbox_slam
