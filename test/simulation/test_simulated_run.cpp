#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

SimulationOptions short_run() {
  SimulationOptions options;
  options.time.duration = 6.0;
  options.laser.beams = 100;
  return options;
}

TEST(SimulatedRun, ScansComeAtTheirRateWithTruthAndOdometryAround) {
  const World world = make_rooms_world(1);
  const SimulatedRun run = simulate_run(world, world.route(), short_run(), 7);
  ASSERT_EQ(run.scans.size(), 121U);
  ASSERT_EQ(run.world_from_base.size(), run.scans.size());
  EXPECT_EQ(run.scans.front().stamp, SimulationOptions{}.time.start_stamp);
  for (std::size_t i = 1; i < run.scans.size(); ++i) {
    EXPECT_NEAR(run.scans[i].stamp - run.scans[i - 1].stamp, 0.05, 1e-6);
  }
  EXPECT_EQ(run.odometry.front().stamp, run.scans.front().stamp);
  EXPECT_GE(run.odometry.back().stamp, run.scans.back().stamp + run.scans.back().duration());
  EXPECT_NEAR(static_cast<double>(run.odometry.size()), 301.0, 1.0);
}

TEST(SimulatedRun, WithoutNoiseEveryScanIsTheIdealOneAtTheTruePose) {
  const World world = make_rooms_world(1);
  const SimulationOptions options = without_noise(short_run());
  const SimulatedRun run = simulate_run(world, world.route(), options, 7);
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    EXPECT_TRUE(
        are_same_ranges(run.scans[i], ideal_scan(world, options.laser, run.world_from_base[i])));
    const ScanInput input = scan_input(run, i);
    ASSERT_TRUE(input.odometry);
    const Pose2 pose = run.world_from_base.front() * input.odometry->odom_from_base;
    // Between two readings the odometry goes straight on where the robot drove an arc.
    EXPECT_LT((pose.translation() - run.world_from_base[i].translation()).norm(), 1e-3);
    EXPECT_FALSE(scan_input(run, i, false).odometry);
  }
}

TEST(SimulatedRun, TheSeedSaysEverything) {
  const World world = make_rooms_world(1);
  const SimulatedRun run = simulate_run(world, world.route(), short_run(), 7);
  const SimulatedRun same = simulate_run(world, world.route(), short_run(), 7);
  const SimulatedRun other = simulate_run(world, world.route(), short_run(), 8);
  int equal_scans = 0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    ASSERT_TRUE(are_same_ranges(run.scans[i], same.scans[i]));
    ASSERT_EQ(run.world_from_base[i], same.world_from_base[i]);
    ASSERT_EQ(run.world_from_base[i], other.world_from_base[i]);
    equal_scans += are_same_ranges(run.scans[i], other.scans[i]) ? 1 : 0;
  }
  EXPECT_EQ(equal_scans, 0);
  EXPECT_EQ(run.odometry.back().odom_from_base, same.odometry.back().odom_from_base);
  EXPECT_NE(run.odometry.back().odom_from_base, other.odometry.back().odom_from_base);
}

TEST(SimulatedRun, WithoutADurationItLastsAsLongAsTheRoute) {
  const World world = make_corridor_world(1);
  SimulationOptions options = short_run();
  options.time.duration = 0.0;
  options.laser.beams = 1;
  const SimulatedRun run = simulate_run(world, world.route(), options, 7);
  const Eigen::Vector2d end = world.route().waypoints.back();
  EXPECT_LT((run.world_from_base.back().translation() - end).norm(), 0.05);
}

TEST(SimulatedRun, FaultsAreInTheSensorsAndTheTruthIsKnown) {
  const World world = make_rooms_world(1);
  SimulationOptions options = short_run();
  options.time.duration = 12.0;
  const SimulatedRun sound = simulate_run(world, world.route(), options, 7);
  options.faults = {parse_fault("encoders:3:1"), parse_fault("dropout:5:1"),
                    parse_fault("kidnap:7:1:2"), parse_fault("people:random:1")};
  const SimulatedRun run = simulate_run(world, world.route(), options, 7);
  ASSERT_EQ(run.faults.size(), 4U);
  EXPECT_FALSE(std::isnan(run.faults[3].time));
  EXPECT_EQ(run.scans.size(), sound.scans.size() - 20U);
  ASSERT_EQ(run.world_from_base.size(), run.scans.size());
  double farthest = 0.0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const double time = run.scans[i].stamp - run.scans.front().stamp;
    // A scan without a fault at its time has the readings that it has in a sound run.
    const auto k = static_cast<std::size_t>(std::lround(20.0 * time));
    if (time < 7.0 && !run.faults[3].is_on(time)) {
      EXPECT_TRUE(are_same_ranges(run.scans[i], sound.scans[k])) << time;
      EXPECT_EQ(run.world_from_base[i], sound.world_from_base[k]);
    }
    farthest = std::max(
        farthest,
        (run.world_from_base[i].translation() - sound.world_from_base[k].translation()).norm());
  }
  EXPECT_GT(farthest, 1.9);
}

TEST(SimulatedRun, FaultsThatLeaveNoScanAreRefused) {
  const World world = make_corridor_world(1);
  SimulationOptions options = short_run();
  options.faults = {parse_fault("dropout:0:100")};
  EXPECT_THROW((void)simulate_run(world, world.route(), options, 7), ConfigurationError);
}

}  // namespace
}  // namespace matchbox_slam
