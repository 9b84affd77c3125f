#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "matching/rendered_map.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/map_equality.hpp"

namespace matchbox_slam {
namespace {

std::shared_ptr<const ScanMatcher> monte_carlo() { return std::make_shared<MonteCarloMatcher>(); }
std::shared_ptr<const ScanMatcher> odometry_only() {
  return std::make_shared<OdometryOnlyMatcher>();
}

/// Finds nothing, ever.
class RejectingMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    return rejected(problem, MatchStatus::kRejectedLowScore);
  }
};

/// Believes the prediction, with a score of its own.
class ScoringMatcher : public RejectingMatcher {
 public:
  explicit ScoringMatcher(double score, double heading_sigma = 0.01)
      : score_(score), heading_sigma_(heading_sigma) {}
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    MatchResult result = rejected(problem, MatchStatus::kAccepted);
    result.score = score_;
    result.covariance = covariance_of(0.01, heading_sigma_);
    return result;
  }

 private:
  double score_;
  double heading_sigma_;  // [rad]
};

SimulatedRun drive_through(const std::string& world_name, double duration, std::uint64_t seed,
                           SimulationOptions options = {}) {
  const World world = make_world(world_name, seed);
  options.time.duration = duration;
  return simulate_run(world, world.route(), options, seed);
}

std::vector<ScanOutcome> process(const SimulatedRun& run, SlamEngine& engine,
                                 bool with_odometry = true) {
  std::vector<ScanOutcome> outcomes;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    outcomes.push_back(engine.process(scan_input(run, i, with_odometry)));
  }
  return outcomes;
}

/// The engine's map starts at the first pose of the robot.
SlamEngine make_engine(const SimulatedRun& run,
                       const std::shared_ptr<const ScanMatcher>& matcher = monte_carlo(),
                       const EngineOptions& options = {}) {
  return {options, matcher, 1, run.world_from_base.front()};
}

/// Root mean square of the distance from the truth [m].
double rms_error(const SimulatedRun& run, const std::vector<ScanOutcome>& outcomes) {
  double sum = 0.0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    sum += (outcomes[i].map_from_base.translation() - run.world_from_base[i].translation())
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(outcomes.size()));
}

double rms_error_of_odometry(const SimulatedRun& run) {
  SlamEngine engine = make_engine(run, odometry_only());
  return rms_error(run, process(run, engine));
}

ScanOdometry at_rest_at(const Pose2& odom_from_base) { return {odom_from_base, odom_from_base}; }

LaserScan lost_scan(std::size_t beams, double stamp, float reading) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min = -1.0;
  scan.angle_increment = 2.0 / 100.0;
  scan.range_min = 0.1;
  scan.range_max = 30.0;
  scan.ranges.assign(beams, reading);
  return scan;
}

// --- accuracy ---

struct Course {
  const char* world;
  double limit;  ///< [m], about 1.5 times the 1.4 mm, 5.3 mm and 2.2 mm that were measured
};

class SlamEngineOn : public testing::TestWithParam<Course> {};

TEST_P(SlamEngineOn, FollowsTheTruth) {
  const SimulatedRun run = drive_through(GetParam().world, 25.0, 3);
  SlamEngine engine = make_engine(run);
  const double error = rms_error(run, process(run, engine));
  EXPECT_LT(error, GetParam().limit);
  EXPECT_LT(error, 0.5 * rms_error_of_odometry(run));
}

INSTANTIATE_TEST_SUITE_P(Worlds, SlamEngineOn,
                         testing::Values(Course{"rooms", 0.0022}, Course{"random", 0.008},
                                         Course{"loop", 0.0035}),
                         [](const testing::TestParamInfo<Course>& test) {
                           return std::string(test.param.world);
                         });

/// With 32 beams, 0.4 m apart at 2 m, the next scan hits other spots of each surface.
TEST(SlamEngine, IsNotHeldByWhatFewBeamsHit) {
  SimulationOptions options;
  options.laser.beams = 32;
  options.laser.field_of_view = 2.0 * kPi;
  options.laser.range_max = 4.0;
  options.laser.scan_rate = 10.0;
  options.odometry = {50.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  // [m], 1.5 times what is measured; 0.077 and 0.46 where hits are taken for all of a surface.
  for (const auto& [seed, limit] :
       {std::pair(std::uint64_t{3}, 0.0045), std::pair(std::uint64_t{4}, 0.031)}) {
    const SimulatedRun run = drive_through("street", 40.0, seed, options);
    SlamEngine engine = make_engine(run, std::make_shared<OlsonMatcher>());
    EXPECT_LT(rms_error(run, process(run, engine)), limit) << seed;
  }
}

TEST(SlamEngine, FollowsTheTruthWithoutOdometry) {
  const SimulatedRun run = drive_through("rooms", 25.0, 3);
  SlamEngine engine = make_engine(run);
  const std::vector<ScanOutcome> outcomes = process(run, engine, false);
  EXPECT_LT(rms_error(run, outcomes), 0.0022);  // measured: 1.4 mm
  for (const ScanOutcome& outcome : outcomes) {
    EXPECT_FALSE(outcome.odom_from_base);
  }
}

TEST(SlamEngine, TakesOutTheMotionDuringTheScan) {
  SimulationOptions options;
  options.laser.time_increment = 0.04 / 1040;  // the sweep takes most of the time between scans
  options.drive.speed = 1.0;
  options.drive.turn_rate = 1.5;
  const SimulatedRun run = drive_through("rooms", 15.0, 3, options);
  SlamEngine engine = make_engine(run);
  const double with_deskew = rms_error(run, process(run, engine));
  SimulatedRun instantaneous = run;
  for (LaserScan& scan : instantaneous.scans) {
    scan.time_increment = 0.0;
  }
  SlamEngine bent = make_engine(instantaneous);
  const double without = rms_error(instantaneous, process(instantaneous, bent));
  SlamEngine by_velocity = make_engine(run);
  const double without_odometry = rms_error(run, process(run, by_velocity, false));
  // Measured: 3.3 mm, 21 mm and 13 mm.
  EXPECT_LT(with_deskew, 0.005);
  EXPECT_GT(without, 3.0 * with_deskew);
  EXPECT_LT(without_odometry, 0.02);
}

/// See without_overshoot.
TEST(SlamEngine, ALaserThatAlwaysSweepsMapsWithoutOdometry) {
  SimulationOptions options;
  options.laser.field_of_view = 2.0 * kPi;
  options.laser.scan_rate = 8.0;
  options.laser.time_increment = 0.99 / (8.0 * 1040.0);
  options.drive.speed = 1.0;
  const SimulatedRun run = drive_through("rooms", 30.0, 5, options);
  SlamEngine engine = make_engine(run);
  const double error = rms_error(run, process(run, engine, false));
  RecordProperty("rms", std::to_string(error));
  // Measured: 4.9 mm; 82 mm with a match as it is.
  EXPECT_LT(error, 0.0073);
}

// --- the same bits ---

TEST(SlamEngine, TheSameRunGivesTheSameBits) {
  const SimulatedRun run = drive_through("rooms", 12.0, 5);
  SlamEngine first = make_engine(run);
  SlamEngine second = make_engine(run);
  const std::vector<ScanOutcome> a = process(run, first);
  const std::vector<ScanOutcome> b = process(run, second);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].map_from_base, b[i].map_from_base) << i;
    ASSERT_EQ(a[i].covariance, b[i].covariance) << i;
    ASSERT_EQ(a[i].match.score, b[i].match.score) << i;
    ASSERT_EQ(a[i].inserted, b[i].inserted) << i;
  }
  EXPECT_TRUE(same_map(first.map(), second.map()));
}

TEST(SlamEngine, ACopyOfTheMapStaysAsItWas) {
  const SimulatedRun run = drive_through("rooms", 12.0, 5);
  SlamEngine engine = make_engine(run);
  engine.process(scan_input(run, 0));
  const SlamMap snapshot = engine.map();
  SlamEngine only_one = make_engine(run);
  only_one.process(scan_input(run, 0));
  for (std::size_t i = 1; i < run.scans.size(); ++i) {
    engine.process(scan_input(run, i));
  }
  EXPECT_TRUE(same_map(snapshot, only_one.map()));
  EXPECT_FALSE(same_map(snapshot, engine.map()));
}

// --- loops ---

/// A lap and more on a ring, with odometry that is half a metre off when it comes home.
const SimulatedRun& drive_round_a_block() {
  static const SimulatedRun run = [] {
    SimulationOptions options;
    options.laser.beams = 130;
    options.laser.scan_rate = 4.0;
    options.drive.speed = 1.0;
    options = without_noise(options);
    options.odometry.rotation_bias = 0.005;
    const World world = make_world("loop", 2);
    return simulate_run(world, world.route(), options, 2);
  }();
  return run;
}

/// Believes odometry, and remembers what it was given to match against.
class FieldRecorder : public OdometryOnlyMatcher {
 public:
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    field = problem.field;
    return OdometryOnlyMatcher::match(problem);
  }
  mutable std::optional<LikelihoodField> field;
};

/// An engine on a drive round a block, that goes on from wherever it is.
class LoopDrive {
 public:
  explicit LoopDrive(bool closes_loops = true) {
    options.hypotheses.enabled = false;
    options.slam.loop_closing = closes_loops;
    engine = std::make_unique<SlamEngine>(options, matcher, 1, run.world_from_base.front());
  }

  const ScanOutcome& process_next() {
    outcomes.push_back(engine->process(scan_input(run, outcomes.size())));
    return outcomes.back();
  }

  void process_until_corrected() {
    while (!process_next().corrected) {
      ASSERT_LT(outcomes.size(), run.scans.size()) << "no loop was closed";
    }
  }

  void process_all() {
    while (outcomes.size() < run.scans.size()) {
      process_next();
    }
  }

  const SimulatedRun& run = drive_round_a_block();
  EngineOptions options;
  std::shared_ptr<FieldRecorder> matcher = std::make_shared<FieldRecorder>();
  std::unique_ptr<SlamEngine> engine;
  std::vector<ScanOutcome> outcomes;
};

TEST(SlamEngineLoops, AskingForTheMapChangesNothing) {
  LoopDrive drive;
  LoopDrive asking;
  bool was_corrected = false;
  for (std::size_t i = 0; i < drive.run.scans.size(); ++i) {
    was_corrected = drive.process_next().corrected || was_corrected;
    asking.process_next();
    static_cast<void>(asking.engine->map());
    ASSERT_EQ(drive.outcomes[i].map_from_base, asking.outcomes[i].map_from_base) << i;
    if (was_corrected && i % 5 == 0) {
      ASSERT_EQ(drive.matcher->field->surface_cells(), asking.matcher->field->surface_cells()) << i;
    }
  }
  EXPECT_TRUE(was_corrected);
  EXPECT_TRUE(same_map(drive.engine->map(), asking.engine->map()));
}

TEST(SlamEngineLoops, TakesAMapThatWasRenderedBesideTheMapping) {
  LoopDrive drive;
  SlamEngine& engine = *drive.engine;
  PlacedScans keys;
  const auto render = [&] { return rendered(keys, drive.options.map, drive.options.field); };
  do {
    keys = engine.key_scans().all();
    ASSERT_FALSE(engine.is_outdated());
  } while (!drive.process_next().corrected);
  ASSERT_TRUE(engine.is_outdated());
  engine.take_rendered(render(), keys);
  EXPECT_TRUE(engine.is_outdated()) << "key scans have moved since";
  keys = engine.key_scans().all();
  for (int i = 0; i < 10; ++i) {
    drive.process_next();
  }
  ASSERT_GT(engine.key_scans().size(), keys.size());
  engine.take_rendered(render(), keys);
  ASSERT_FALSE(engine.is_outdated());
  keys = engine.key_scans().all();
  EXPECT_TRUE(same_map(engine.map(), render()));
}

TEST(SlamEngineLoops, APoseThatIsToldIsLookedForInTheWholeMap) {
  LoopDrive drive;
  drive.process_until_corrected();
  const std::size_t elsewhere = drive.run.scans.size() / 2;
  drive.engine->set_pose(drive.run.world_from_base[elsewhere], Eigen::Matrix3d::Identity());
  const LikelihoodField whole = drive.engine->map().field;
  drive.process_next();
  EXPECT_EQ(drive.matcher->field->surface_cells(), whole.surface_cells());
}

TEST(SlamEngineLoops, CanBeSwitchedOffOnTheWay) {
  LoopDrive drive;
  drive.process_until_corrected();
  drive.options.slam.loop_closing = false;
  drive.engine->set_options(drive.options);
  for (int i = 0; i < 20; ++i) {
    const LikelihoodField whole = drive.engine->map().field;
    drive.process_next();
    ASSERT_EQ(drive.matcher->field->surface_cells(), whole.surface_cells()) << i;
  }
}

TEST(SlamEngineLoops, AClosedLoopMovesAllThatTheEngineKnows) {
  LoopDrive drive;
  drive.process_until_corrected();
  const std::size_t at = drive.outcomes.size() - 1;
  const ScanOutcome& outcome = drive.outcomes.back();
  const auto error = [&](std::size_t i, const Pose2& pose) {
    return (pose.translation() - drive.run.world_from_base[i].translation()).norm();
  };
  EXPECT_GT(error(at - 1, drive.outcomes[at - 1].map_from_base), 0.3);  // 0.4
  EXPECT_LT(error(at, outcome.map_from_base), 0.02);
  // The prediction was by odometry alone, of which nothing was taken back.
  EXPECT_EQ(outcome.predicted_map_from_base, outcome.map_from_base);
  EngineState now = drive.engine->snapshot();
  EXPECT_LT(difference(now.key_scans.all().back().map_from_base, outcome.map_from_base).norm(),
            1e-12);
  EXPECT_EQ(now.motion.fixed_from_base, outcome.map_from_base);
  EXPECT_EQ(now.last_inserted.at(0), outcome.map_from_base);
  const auto& poses = drive.engine->graph().poses;
  ASSERT_EQ(poses.size(), now.key_scans.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ASSERT_EQ(now.key_scans.all()[i].map_from_base, poses[i]) << i;
  }
  now.map.field.render();  // until then it lacks likelihoods, as it is not matched against
  EXPECT_TRUE(
      same_map(now.map, rendered(now.key_scans.all(), drive.options.map, drive.options.field)));
  // Nothing waits for the map to be rendered: the next scan goes on from there.
  drive.process_next();
  EXPECT_LT(error(at + 1, drive.outcomes.back().map_from_base), 0.03);
}

TEST(SlamEngineLoops, AnotherDriveIsMatchedAgainstAMapThatIsRendered) {
  LoopDrive drive;
  drive.process_until_corrected();
  EngineState start = drive.engine->snapshot();
  EXPECT_FALSE(start.map.field.is_rendered());
  start.begin_anew(drive.outcomes.back().map_from_base, 1e-4 * Eigen::Matrix3d::Identity());
  EXPECT_TRUE(
      same_map(start.map, rendered(start.key_scans.all(), drive.options.map, drive.options.field)));
}

/// Share of the surfaces [0, 1] that lie farther than this [m] from any of another map.
double share_off(const LikelihoodField& field, const LikelihoodField& truth) {
  const std::vector<Cell> cells = field.surface_cells();
  const auto is_off = [&](const Cell& cell) {
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        if (truth.has_surface({cell.x + x, cell.y + y})) {
          return false;
        }
      }
    }
    return true;
  };
  return static_cast<double>(std::count_if(cells.begin(), cells.end(), is_off)) /
         static_cast<double>(cells.size());
}

TEST(SlamEngineLoops, NoWallIsDrawnTwiceWhereTheLoopWasClosed) {
  const auto seen_at_home = [](LoopDrive& drive, bool at_true_places) {
    // Key scans of the first and of the last 10 m.
    std::map<double, Pose2> truth;
    for (std::size_t i = 0; i < drive.run.scans.size(); ++i) {
      truth[drive.run.scans[i].stamp] = drive.run.world_from_base[i];
    }
    PlacedScans keys;
    for (const PlacedScan& key : drive.engine->key_scans().all()) {
      const Pose2& pose = truth.at(key.scan->stamp());
      if ((pose.translation() - drive.run.world_from_base.front().translation()).norm() < 10.0) {
        keys.push_back({key.scan, at_true_places ? pose : key.map_from_base});
      }
    }
    return rendered(keys, drive.options.map, drive.options.field);
  };
  LoopDrive closing;
  closing.process_all();
  LoopDrive open(false);
  open.process_all();
  const SlamMap truth = seen_at_home(closing, true);
  const double closed_off = share_off(seen_at_home(closing, false).field, truth.field);
  const double open_off = share_off(seen_at_home(open, false).field, truth.field);
  EXPECT_LT(closed_off, 0.01);  // 0.004
  EXPECT_GT(open_off, 0.3);     // 0.54
}

TEST(SlamEngineLoops, TheSameDriveGivesTheSameBits) {
  LoopDrive drive;
  LoopDrive again;
  drive.process_all();
  again.process_all();
  ASSERT_FALSE(drive.engine->graph().poses.empty());
  for (std::size_t i = 0; i < drive.outcomes.size(); ++i) {
    ASSERT_EQ(drive.outcomes[i].map_from_base, again.outcomes[i].map_from_base) << i;
    ASSERT_EQ(drive.outcomes[i].covariance, again.outcomes[i].covariance) << i;
  }
  EXPECT_TRUE(same_map(drive.engine->map(), again.engine->map()));
}

TEST(SlamEngineLoops, GoneOnWithFromAnyScanTheDriveIsTheSame) {
  LoopDrive whole;
  whole.process_all();
  std::size_t moved_at = 0;
  while (!whole.outcomes[moved_at].corrected) {
    ++moved_at;
  }
  for (const std::size_t at : {moved_at - 12, moved_at - 2, moved_at, moved_at + 1}) {
    LoopDrive interrupted;
    while (interrupted.outcomes.size() <= at) {
      interrupted.process_next();
    }
    EngineState start = interrupted.engine->snapshot();
    interrupted.engine->start_from(start);
    interrupted.process_all();
    for (std::size_t i = at; i < whole.outcomes.size(); ++i) {
      ASSERT_EQ(whole.outcomes[i].map_from_base, interrupted.outcomes[i].map_from_base)
          << i << " after " << at;
    }
    EXPECT_TRUE(same_map(whole.engine->map(), interrupted.engine->map()));
  }
}

TEST(SlamEngineLoops, AreNotClosedInAMapWithWallsOfItsOwn) {
  LoopDrive drive;
  drive.process_next();
  EngineState start = drive.engine->snapshot();
  start.is_of_key_scans = false;
  drive.engine->start_from(start);
  drive.process_all();
  EXPECT_EQ(drive.engine->loop_tries(), 0U);
}

TEST(SlamEngineLoops, WhereNoneIsClosedTheyChangeNothing) {
  LoopDrive closing;
  LoopDrive open(false);
  while (!closing.process_next().corrected) {
    const ScanOutcome& outcome = open.process_next();
    ASSERT_EQ(closing.outcomes.back().map_from_base, outcome.map_from_base);
    ASSERT_EQ(closing.outcomes.back().covariance, outcome.covariance);
  }
  open.process_all();
  EXPECT_TRUE(open.engine->graph().poses.empty());
  EXPECT_TRUE(same_map(open.engine->map(), rendered(open.engine->key_scans().all(),
                                                    open.options.map, open.options.field)));
}

// --- along a corridor ---

TEST(SlamEngine, AlongACorridorItIsNoWorseThanOdometry) {
  SimulationOptions options;
  options.laser.beams = 130;
  options.laser.scan_rate = 10.0;
  const SimulatedRun run = drive_through("corridor", 100.0, 1, options);
  SlamEngine engine = make_engine(run, std::make_shared<OlsonMatcher>());
  double worst = 0.0;
  std::size_t i = 0;
  for (const ScanOutcome& outcome : process(run, engine)) {
    worst = std::max(
        worst,
        (outcome.map_from_base.translation() - run.world_from_base[i++].translation()).norm());
    ASSERT_LT(outcome.covariance(0, 0), 25.0);
  }
  EXPECT_LT(worst, 0.8);
}

// --- at rest ---

TEST(SlamEngine, ARobotAtRestNeitherDriftsNorWearsItsMapOut) {
  SimulationOptions options;
  options.laser.beams = 360;
  const SimulatedRun run = drive_through("rooms", 0.1, 3, options);
  SlamEngine engine = make_engine(run);
  ScanInput input = scan_input(run, 0);
  engine.process(input);
  const SlamMap after_first = engine.map();
  for (int i = 1; i <= 1000; ++i) {
    input.scan.stamp += 0.05;
    const ScanOutcome outcome = engine.process(input);
    ASSERT_TRUE(outcome.match.accepted());
    ASSERT_FALSE(outcome.inserted);
    const Pose2 moved = run.world_from_base.front().inverse() * outcome.map_from_base;
    ASSERT_LT(moved.translation().norm(), 0.003) << "after " << i << " scans";
    ASSERT_LT(std::abs(moved.theta), 0.001) << "after " << i << " scans";
  }
  EXPECT_TRUE(same_map(after_first, engine.map()));
}

TEST(SlamEngine, InsertsAfterEnoughMotionOnly) {
  EngineOptions options;
  options.slam.insert_distance = 0.5;
  options.slam.insert_angle = 0.4;
  const SimulatedRun run = drive_through("rooms", 20.0, 3);
  SlamEngine engine = make_engine(run, monte_carlo(), options);
  Pose2 last_inserted = run.world_from_base.front();
  int inserted = 0;
  for (const ScanOutcome& outcome : process(run, engine)) {
    if (outcome.inserted && ++inserted > 1) {
      const Pose2 moved = last_inserted.inverse() * outcome.map_from_base;
      EXPECT_TRUE(moved.translation().norm() >= 0.5 || std::abs(moved.theta) >= 0.4);
    }
    last_inserted = outcome.inserted ? outcome.map_from_base : last_inserted;
  }
  EXPECT_GE(inserted, 6);
  ASSERT_EQ(engine.key_scans().size(), static_cast<std::size_t>(inserted)) << "all are kept";
  EXPECT_EQ(engine.key_scans().all().back().map_from_base, last_inserted) << "oldest first";
}

/// Remembers what it was given.
class RecordingMatcher : public OdometryOnlyMatcher {
 public:
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    recent = problem.recent_scans;
    return OdometryOnlyMatcher::match(problem);
  }
  mutable PlacedScans recent;
};

TEST(SlamEngine, GivesTheNewestKeyScansToTheMatcherWithTheirPointsToTheBit) {
  EngineOptions options;
  options.slam.recent_scans = 3;
  options.slam.insert_distance = 0.0;
  options.slam.insert_angle = 0.0;
  const auto matcher = std::make_shared<RecordingMatcher>();
  const SimulatedRun run = drive_through("rooms", 1.0, 3);
  SlamEngine engine = make_engine(run, matcher, options);
  const std::vector<ScanOutcome> outcomes = process(run, engine);
  const std::size_t last = outcomes.size() - 1;
  ASSERT_EQ(matcher->recent.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const PlacedScan& placed = matcher->recent[i];
    EXPECT_EQ(placed.scan->id(), last - 3 + i);
    EXPECT_EQ(placed.map_from_base, outcomes[last - 3 + i].map_from_base);
    EXPECT_EQ(placed.scan->points()->stamp, outcomes[last - 3 + i].stamp);
  }
  const ScanInput input = scan_input(run, last - 1);
  const PointScan expected = project_scan(
      input.scan, input.base_from_laser,
      input.odometry->odom_from_base.inverse() * input.odometry->odom_from_base_last_beam,
      options.scan);
  const std::shared_ptr<const PointScan> points = matcher->recent.back().scan->points();
  ASSERT_EQ(points->points.size(), expected.points.size());
  for (std::size_t k = 0; k < expected.points.size(); ++k) {
    ASSERT_EQ(points->points[k].position, expected.points[k].position);
    ASSERT_EQ(points->points[k].moved, expected.points[k].moved);
  }
  EXPECT_EQ(points->free_rays.size(), expected.free_rays.size());
}

TEST(SlamEngine, InsertsWhatOverlapsTooLittleToo) {
  const auto inserted = [](double score, double insert_overlap) {
    EngineOptions options;
    options.slam.insert_overlap = insert_overlap;
    SlamEngine engine(options, std::make_shared<ScoringMatcher>(score), 1);
    ScanInput input;
    input.scan = lost_scan(100, 1.0, 3.0F);
    input.odometry = at_rest_at({});
    EXPECT_TRUE(engine.process(input).inserted);
    input.scan.stamp = 2.0;
    return engine.process(input).inserted;
  };
  EXPECT_TRUE(inserted(0.59, 0.6));
  EXPECT_FALSE(inserted(0.6, 0.6));
  EXPECT_FALSE(inserted(0.0, 0.0)) << "off";
  EXPECT_FALSE(inserted(0.0, EngineOptions{}.slam.insert_overlap)) << "off unless asked for";

  EngineOptions options;
  options.slam.insert_overlap = 1.0;
  SlamEngine engine(options, std::make_shared<RejectingMatcher>(), 1);
  ScanInput input;
  input.scan = lost_scan(100, 1.0, 3.0F);
  EXPECT_TRUE(engine.process(input).inserted);
  input.scan.stamp = 2.0;
  EXPECT_FALSE(engine.process(input).inserted) << "never what was rejected";
}

/// What is 5 m away would be drawn 0.25 m off.
TEST(SlamEngine, DoesNotInsertWhatIsTurnedNobodyKnowsHow) {
  const auto inserted = [](double score, double heading_sigma) {
    EngineOptions options;
    options.slam.insert_overlap = 1.0;
    SlamEngine engine(options, std::make_shared<ScoringMatcher>(score, heading_sigma), 1);
    ScanInput input;
    input.scan = lost_scan(100, 1.0, 3.0F);
    input.odometry = at_rest_at({});
    EXPECT_TRUE(engine.process(input).inserted);
    input.scan.stamp = 2.0;
    return engine.process(input).inserted;
  };
  EXPECT_TRUE(inserted(0.9, 0.04));
  EXPECT_FALSE(inserted(0.9, 0.06));
  EXPECT_TRUE(inserted(0.0, 0.06)) << "odometry alone is believed";
}

TEST(SlamEngine, InsertsWhatALaserSeesAtHalfTheTilt) {
  SlamEngine engine({}, odometry_only(), 1);
  ScanInput input;
  input.scan = lost_scan(100, 0.0, 3.0F);
  input.odometry = at_rest_at({});
  const auto inserts_at = [&](double tilt) {
    input.scan.stamp += 1.0;
    input.base_from_laser = Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY());
    return engine.process(input).inserted;
  };
  EXPECT_TRUE(inserts_at(-0.1));
  EXPECT_FALSE(inserts_at(-0.12));
  EXPECT_FALSE(inserts_at(-0.06));
  EXPECT_TRUE(inserts_at(0.04));
  EXPECT_FALSE(inserts_at(-0.03));
  EXPECT_TRUE(inserts_at(0.008));
  EXPECT_FALSE(inserts_at(0.0)) << "it saw all already";
}

// --- predictions ---

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

// --- hostile input ---

TEST(SlamEngine, AScanThatIsRefusedChangesNothing) {
  const SimulatedRun run = drive_through("rooms", 1.0, 3);
  SlamEngine engine = make_engine(run);
  SlamEngine unspoilt = make_engine(run);
  engine.process(scan_input(run, 1));
  unspoilt.process(scan_input(run, 1));
  ScanInput bad_odometry = scan_input(run, 2);
  bad_odometry.odometry->odom_from_base.x = std::numeric_limits<double>::quiet_NaN();
  for (const ScanInput& input : {scan_input(run, 0), scan_input(run, 1), bad_odometry}) {
    EXPECT_THROW(engine.process(input), std::invalid_argument);
  }
  EXPECT_TRUE(same_map(unspoilt.map(), engine.map()));
  const ScanOutcome outcome = engine.process(scan_input(run, 2));
  EXPECT_TRUE(outcome.match.accepted());
  EXPECT_EQ(outcome.map_from_base, unspoilt.process(scan_input(run, 2)).map_from_base);
}

TEST(SlamEngine, LeavesOutAScanForWhichTheMapHasNoRoom) {
  const SimulatedRun run = drive_through("rooms", 1.0, 3);
  EngineOptions options;
  options.slam.insert_distance = 0.0;
  options.slam.insert_angle = 0.0;
  SlamEngine engine(options, odometry_only(), 1);
  EXPECT_TRUE(engine.process(scan_input(run, 0)).inserted);
  const std::size_t bytes = engine.map().occupancy.bytes() + engine.map().field.bytes();
  ScanInput wild = scan_input(run, 1);
  for (Pose2* pose : {&wild.odometry->odom_from_base, &wild.odometry->odom_from_base_last_beam}) {
    pose->x += 1e7;
    pose->y -= 1e7;
  }
  const ScanOutcome outcome = engine.process(wild);
  EXPECT_TRUE(outcome.left_out);
  EXPECT_FALSE(outcome.inserted);
  EXPECT_EQ(engine.map().occupancy.bytes() + engine.map().field.bytes(), bytes);
  EXPECT_TRUE(engine.process(scan_input(run, 2)).inserted);
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

TEST(SlamEngine, WithoutUpdatesTheMapOnlyTellsWhereTheRobotIs) {
  const SimulatedRun run = drive_through("rooms", 12.0, 5);
  SlamEngine mapped = make_engine(run);
  process(run, mapped);
  EngineOptions options;
  options.slam.update_map = false;
  SlamEngine engine = make_engine(run, monte_carlo(), options);
  EngineState start = mapped.snapshot();
  start.begin_anew(run.world_from_base.front(), start.motion.covariance);
  engine.start_from(start);
  const std::vector<ScanOutcome> outcomes = process(run, engine);
  EXPECT_TRUE(same_map(engine.map(), mapped.map()));
  EXPECT_EQ(engine.key_scans().size(), mapped.key_scans().size());
  EXPECT_LT(rms_error(run, outcomes), 0.005);
  // Without a map there is nothing to tell, and none is made.
  SlamEngine empty = make_engine(run, monte_carlo(), options);
  EXPECT_EQ(process(run, empty).back().match.status, MatchStatus::kRejectedNoReference);
  EXPECT_TRUE(empty.map().field.empty());
}

TEST(SlamEngine, OptionsAndMatcherMayChangeOnTheWay) {
  const SimulatedRun run = drive_through("rooms", 12.0, 5);
  SlamEngine engine = make_engine(run);
  engine.process(scan_input(run, 0));
  EngineOptions options;
  options.slam.insert_distance = 0.0;
  options.slam.insert_angle = 0.0;
  engine.set_options(options);
  engine.set_matcher(odometry_only());
  EXPECT_TRUE(engine.process(scan_input(run, 1)).inserted);
  options.map.resolution = 0.1;
  EXPECT_EQ(error_text<ConfigurationError>([&] { engine.set_options(options); }),
            "map/resolution: 0.1 is not allowed with a map that was made with 0.05; allowed: the "
            "same, or a new map");
  EXPECT_EQ(engine.options().map.resolution, 0.05);
  EngineState other{SlamMap(options.map, options.field), {}, {}, {}, 0};
  EXPECT_THROW(engine.start_from(other), ConfigurationError);
}

// --- several lasers ---

/// A robot with a laser that looks ahead and one that looks back, where tf has the latter by
/// 3 cm and 2 degrees elsewhere.
SimulatedRun drive_with_two(double duration, const Pose2& tf_error, double field_of_view = 4.5) {
  SimulationOptions options;
  options.laser.beams = 400;
  options.laser.field_of_view = field_of_view;
  const Pose2 at{-0.275, 0.05, kPi - 0.1};
  options.second_laser = SecondLaserOptions{at, displaced(at, {tf_error.x, tf_error.y, 0.0})};
  options.second_laser->tf_base_from_laser.theta = wrap_angle(at.theta + tf_error.theta);
  return drive_through("rooms", duration, 3, options);
}

ScanInput second_input(const SimulatedRun& run, std::size_t i) {
  ScanInput input = scan_input(run, i);
  input.scan = run.second_scans[i];
  input.base_from_laser = run.base_from_second;
  input.laser = 1;
  return input;
}

/// The poses by the first laser; of one moment the second comes first, as from the queue.
std::vector<ScanOutcome> process_both(const SimulatedRun& run, SlamEngine& engine) {
  std::vector<ScanOutcome> outcomes;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    engine.process(second_input(run, i));
    outcomes.push_back(engine.process(scan_input(run, i)));
  }
  return outcomes;
}

const Pose2 kTfError{0.02, -0.0224, degrees_to_radians(2.0)};

TEST(SlamEngine, FindsWhereASecondLaserIsAndUsesIt) {
  const SimulatedRun run = drive_with_two(30.0, kTfError);
  SlamEngine engine = make_engine(run);
  const std::vector<ScanOutcome> outcomes = process_both(run, engine);
  const SecondaryLaser& laser = engine.secondary_lasers().all().at(1);
  EXPECT_TRUE(laser.is_used);
  const Pose2 tf = laser.base_from_laser;
  EXPECT_NEAR(tf.x, -0.255, 1e-9);
  const Pose2 found = laser.mount.correction(Eigen::Vector3d::Zero()) * tf;
  EXPECT_LT(std::hypot(found.x + 0.275, found.y - 0.05), 0.005);  // 1.5 mm is measured
  EXPECT_LT(std::abs(wrap_angle(found.theta - (kPi - 0.1))), degrees_to_radians(0.2));
  EXPECT_LT(rms_error(run, outcomes), 0.004);  // 2.3 mm; 22 mm with the laser where tf has it
  std::size_t of_second = 0;
  for (const PlacedScan& key : engine.key_scans().all()) {
    of_second += key.scan->laser() == 1 ? 1 : 0;
  }
  EXPECT_GT(2 * of_second, engine.key_scans().size() / 2);
}

/// Until it is sure, the second laser changes nothing; nor does it ever where it sees nothing that
/// the first one has seen lately, and it says so.
TEST(SlamEngine, ASecondLaserThatIsNotSureChangesNoBit) {
  const double narrow = degrees_to_radians(60.0);
  const SimulatedRun run = drive_with_two(20.0, kTfError, narrow);
  SlamEngine engine = make_engine(run);
  SlamEngine alone = make_engine(run);
  const std::vector<ScanOutcome> both = process_both(run, engine);
  const std::vector<ScanOutcome> one = process(run, alone);
  ASSERT_FALSE(engine.secondary_lasers().all().at(1).is_used);
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(both[i].map_from_base, one[i].map_from_base) << i;
    ASSERT_EQ(both[i].covariance, one[i].covariance) << i;
  }
}

TEST(SlamEngine, AnotherLaserLeadsWhileTheFirstIsSilent) {
  const SimulatedRun run = drive_with_two(12.0, Pose2{});
  SlamEngine engine = make_engine(run);
  std::vector<ScanOutcome> outcomes;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const bool is_silent = i < 40 || (i > 120 && i < 200);
    outcomes.push_back(engine.process(second_input(run, i)));
    if (!is_silent) {
      outcomes.back() = engine.process(scan_input(run, i));
    }
  }
  EXPECT_TRUE(outcomes[5].is_of_secondary_laser);
  EXPECT_EQ(outcomes[30].match.status, MatchStatus::kAccepted) << "after half a second";
  EXPECT_EQ(outcomes[150].match.status, MatchStatus::kAccepted);
  EXPECT_EQ(engine.secondary_lasers().primary().laser, 0) << "which is back";
  EXPECT_LT(rms_error(run, outcomes), 0.01);
}

TEST(SlamEngine, WaitsForAScanThatStartsTheMap) {
  const SimulatedRun run = drive_through("rooms", 5.0, 3);
  SlamEngine engine = make_engine(run);
  ScanInput input = scan_input(run, 0);
  const double start = input.scan.stamp;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  input.scan = lost_scan(0, start - 3.0, 0.0F);
  EXPECT_EQ(engine.process(input).match.status, MatchStatus::kRejectedNoReference);
  input.scan = lost_scan(1000, start - 2.0, kNan);
  EXPECT_EQ(engine.process(input).match.status, MatchStatus::kRejectedNoReference);
  input.scan = lost_scan(1000, start - 1.0, std::numeric_limits<float>::infinity());
  EXPECT_EQ(engine.process(input).match.status, MatchStatus::kRejectedNoReference);
  EXPECT_TRUE(engine.map().field.empty());
  const double error = rms_error(run, process(run, engine));
  EXPECT_FALSE(engine.map().field.empty());
  EXPECT_LT(error, 0.02);
}

TEST(SlamEngine, GoesOnAfterScansThatSayNothing) {
  for (const bool with_odometry : {true, false}) {
    SimulatedRun run = drive_through("rooms", 12.0, 3);
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    run.scans[100].ranges.clear();
    std::fill(run.scans[101].ranges.begin(), run.scans[101].ranges.end(), kNan);
    std::fill(run.scans[102].ranges.begin(), run.scans[102].ranges.end(),
              std::numeric_limits<float>::infinity());
    run.scans[103].ranges.resize(1);
    SlamEngine engine = make_engine(run);
    const std::vector<ScanOutcome> outcomes = process(run, engine, with_odometry);
    for (std::size_t i = 100; i <= 103; ++i) {
      EXPECT_EQ(outcomes[i].match.status, MatchStatus::kRejectedTooFewPoints) << i;
      EXPECT_FALSE(outcomes[i].inserted);
      EXPECT_EQ(outcomes[i].map_from_base, outcomes[i].predicted_map_from_base);
    }
    EXPECT_TRUE(outcomes[104].match.accepted());
    EXPECT_LT(rms_error(run, outcomes), 0.02);
  }
}

TEST(SlamEngine, BeamCountAndMountMayChangeFromScanToScan) {
  const World world = make_rooms_world(3);
  const SimulatedRun run = drive_through("rooms", 10.0, 3);
  LaserOptions upside_down;
  upside_down.beams = 541;
  upside_down.mount_roll = kPi;
  upside_down.mount_x = -0.1;
  upside_down.clockwise = true;
  SlamEngine engine = make_engine(run);
  std::vector<ScanOutcome> outcomes;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    ScanInput input = scan_input(run, i);
    if (i % 2 == 1) {
      input.scan = ideal_scan(world, upside_down, run.world_from_base[i], input.scan.stamp);
      input.base_from_laser = upside_down.base_from_laser();
    }
    outcomes.push_back(engine.process(input));
  }
  EXPECT_LT(rms_error(run, outcomes), 0.01);
}

// --- options ---

TEST(EngineOptionsReader, ReadsItsSectionsAndLeavesOthersAlone) {
  Parameters parameters;
  parameters.set("map/resolution", 0.1);
  parameters.set("slam/recent_scans", 7);
  parameters.set("scan/max_range", 12);
  parameters.set("field/sigma", 0.08);
  parameters.set("motion/rotation_floor", 0.5);
  parameters.set("monte_carlo/max_tries", 3);
  parameters.set("matcher", "olson");
  const EngineOptions options = read_engine_options(parameters);
  EXPECT_EQ(options.map.resolution, 0.1);
  EXPECT_EQ(options.slam.recent_scans, 7);
  EXPECT_EQ(options.scan.max_range, 12.0);
  EXPECT_EQ(options.field.sigma, 0.08);
  EXPECT_EQ(options.motion.rotation_floor, 0.5);
  EXPECT_EQ(options.map.quality, MapOptions{}.quality);
}

TEST(EngineOptionsReader, RefusesAThresholdThatNoFirstHitReaches) {
  Parameters parameters;
  parameters.set("map/occupied_threshold", 0.8);
  EXPECT_TRUE(
      contains(error_text<ConfigurationError>([&] { (void)read_engine_options(parameters); }),
               "map/occupied_threshold: 0.8 is not allowed"));
  parameters.set("map/quality", 0.6);
  EXPECT_EQ(read_engine_options(parameters).map.occupied_threshold, 0.8);
}

TEST(EngineOptionsReader, RefusesUnknownKeysOfItsSections) {
  for (const std::string section : {"slam", "scan", "map", "field", "motion"}) {
    Parameters parameters;
    parameters.set(section + "/no_such_option", 1);
    const std::string text =
        error_text<ConfigurationError>([&] { (void)read_engine_options(parameters); });
    EXPECT_TRUE(contains(text, section + ": unknown parameter 'no_such_option'")) << text;
  }
}

TEST(EngineOptionsReader, DescribesWhatItReads) {
  const std::vector<OptionDescription> rows = describe_engine_options({});
  Parameters parameters;
  for (const OptionDescription& row : rows) {
    EXPECT_NE(row.name.find('/'), std::string::npos) << row.name;
    EXPECT_FALSE(row.meaning.empty()) << row.name;
    parameters.set(row.name, row.value);
  }
  const std::vector<OptionDescription> again =
      describe_engine_options(read_engine_options(parameters));
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(again[i].name, rows[i].name);
    EXPECT_EQ(again[i].value, rows[i].value) << rows[i].name;
  }
}

}  // namespace
}  // namespace matchbox_slam
