// Of slam/slam_engine.hpp: several lasers.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/engine_runs.hpp"

namespace matchbox_slam {
namespace {

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

}  // namespace
}  // namespace matchbox_slam
