// Of slam/slam_engine.hpp: loops that are closed on the way.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "matching/rendered_map.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/engine_runs.hpp"
#include "slam/map_equality.hpp"

namespace matchbox_slam {
namespace {

/// A lap and more on a ring, with odometry that is half a metre off when it comes home.
const SimulatedRun& drive_round_a_block() {
  static const SimulatedRun kRun = [] {
    SimulationOptions options;
    options.laser.beams = 130;
    options.laser.scan_rate = 4.0;
    options.drive.speed = 1.0;
    options = without_noise(options);
    options.odometry.rotation_bias = 0.005;
    const World world = make_world("loop", 2);
    return simulate_run(world, world.route(), options, 2);
  }();
  return kRun;
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
  const auto render = [&] {
    return rendered(keys, drive.options.map, drive.options.field, MapUse::kShown);
  };
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
  EXPECT_EQ(now.loops.nodes, now.key_scans.size());
  now.map.field.render();  // until then it lacks likelihoods, as it is not matched against
  EXPECT_TRUE(same_map(now.map, rendered(now.key_scans.all(), drive.options.map,
                                         drive.options.field, MapUse::kShown)));
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
  EXPECT_TRUE(same_map(start.map, rendered(start.key_scans.all(), drive.options.map,
                                           drive.options.field, MapUse::kShown)));
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
    return rendered(keys, drive.options.map, drive.options.field, MapUse::kShown);
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
  EXPECT_EQ(drive.engine->loop_state().tries, 0U);
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
  EXPECT_TRUE(
      same_map(open.engine->map(), rendered(open.engine->key_scans().all(), open.options.map,
                                            open.options.field, MapUse::kShown)));
}

}  // namespace
}  // namespace matchbox_slam
