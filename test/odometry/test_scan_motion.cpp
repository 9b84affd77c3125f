// Of odometry/scan_motion.hpp.

#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"
#include "odometry/scan_motion.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"

namespace matchbox_slam {
namespace {

class ScanMotionTest : public testing::Test {
 protected:
  ScanMotionTest() {
    SimulationOptions options;
    options.time.duration = 8.0;
    options.laser.beams = 520;
    const World world = make_world("rooms", 3);
    run_ = simulate_run(world, world.route(), options, 3);
  }

  /// Odometry is left out.
  Pose2 add(std::size_t scan) {
    ScanInput input;
    input.scan = run_.scans[scan];
    input.base_from_laser = run_.base_from_laser;
    return motion_.add(input).value();
  }

  SimulatedRun run_;
  ScanMotion motion_;
};

TEST_F(ScanMotionTest, IsThatOfTheBase) {
  Pose2 odom_from_base;
  for (std::size_t i = 0; i < run_.scans.size(); ++i) {
    odom_from_base = add(i);
    const Pose2 truth = run_.world_from_base.front().inverse() * run_.world_from_base[i];
    EXPECT_NEAR((odom_from_base.translation() - truth.translation()).norm(), 0.0, 0.02);
    EXPECT_NEAR(wrap_angle(odom_from_base.theta - truth.theta), 0.0, 0.01);
  }
  EXPECT_GT(odom_from_base.translation().norm(), 1.0) << "it has driven";
}

TEST_F(ScanMotionTest, IsSteadyBetweenScansThatAreNear) {
  add(0);
  EXPECT_FALSE(motion_.odom_from_base_at(run_.scans[0].stamp)) << "of one scan";
  const std::size_t last = run_.scans.size() - 1;
  const Pose2 first = add(last - 1);
  EXPECT_FALSE(motion_.odom_from_base_at(run_.scans[last - 1].stamp)) << "far apart in time";
  const Pose2 second = add(last);
  const double stamp = run_.scans[last].stamp;
  const double before = run_.scans[last - 1].stamp;
  const auto middle = motion_.odom_from_base_at(0.5 * (before + stamp));
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->x, 0.5 * (first.x + second.x), 1e-4);
  EXPECT_NEAR(middle->y, 0.5 * (first.y + second.y), 1e-4);
  EXPECT_THROW(add(last), std::bad_optional_access) << "no scan comes twice";
  EXPECT_FALSE(motion_.odom_from_base_at(before - 0.01));
  EXPECT_FALSE(motion_.odom_from_base_at(stamp + 0.01));
}

}  // namespace
}  // namespace matchbox_slam
