#include <gtest/gtest.h>

#include <memory>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "run/start_map.hpp"
#include "slam/lost_robot.hpp"

namespace matchbox_slam {
namespace {

TEST(PutOnMark, ALostRobotStaysLostAndIsFound) {
  const SimulatedRun run = perfect_drive();
  EngineState start = lost_in(map_of(run), run.world_from_base.front() * Pose2{0.4, -0.2, 0.1});
  start.localization.components.front().last_inserted = {{0, {}}};
  const Pose2 active_from_base = start.motion.fixed_from_base;
  set_initial_pose({}, start);
  EXPECT_EQ(start.localization.active, 1U);
  EXPECT_EQ(start.motion.fixed_from_base, active_from_base);
  EXPECT_TRUE(start.localization.components.front().last_inserted.empty()) << "the robot was moved";
  SlamEngine engine({}, std::make_shared<OlsonMatcher>(), 1);
  engine.start_from(start);
  ScanOutcome outcome;
  std::size_t i = 0;
  for (; i < run.scans.size() && !outcome.joined; ++i) {
    outcome = engine.process(scan_input(run, i));
    EXPECT_TRUE(outcome.joined || outcome.state == TrackingState::kLost) << i;
  }
  ASSERT_TRUE(outcome.joined);
  EXPECT_LT((outcome.map_from_base.translation() - run.world_from_base[i - 1].translation()).norm(),
            0.02);
}

TEST(PutOnMark, AnImageSaysNothingOfWhereTheRobotIs) {
  RunOptions options;
  options.start_x = 3.0;
  EngineState start{SlamMap({}, {}), {}, {}, {}, 0};
  set_initial_pose(options, start);
  EXPECT_EQ(start.motion.fixed_from_base, (Pose2{3.0, 0.0, 0.0}));
  EngineState lost = lost_in(start, {1.0, 2.0, 0.0});
  set_initial_pose(options, lost);
  EXPECT_EQ(lost.motion.fixed_from_base, (Pose2{1.0, 2.0, 0.0})) << "in the map apart";
}

TEST(SameDrive, OdometryThatGoesOnIsFarFromItsOrigin) {
  const Pose2 saved{8.0, 6.0, 1.0};
  EXPECT_TRUE(does_odometry_go_on(saved, Pose2{8.5, 6.0, 2.0}, 60.0));
  EXPECT_FALSE(does_odometry_go_on(saved, Pose2{0.1, 0.0, 0.0}, 60.0)) << "it was switched on";
  EXPECT_FALSE(does_odometry_go_on(saved, Pose2{12.0, 6.0, 1.0}, 2.0)) << "none is so fast";
  EXPECT_FALSE(does_odometry_go_on(saved, saved, 3600.0)) << "it may have been carried";
  EXPECT_FALSE(does_odometry_go_on(saved, saved, -1.0)) << "the clock was set back";
  EXPECT_TRUE(does_odometry_go_on(Pose2{2.0, 0.0, 0.0}, Pose2{6.0, 5.0, 0.0}, 40.0))
      << "farther from where it was than from the origin, which says nothing";
  EXPECT_TRUE(does_odometry_go_on(Pose2{0.2, 0.0, 0.0}, Pose2{0.3, 0.0, 0.0}, 60.0))
      << "the next scans have to confirm it";
  EXPECT_FALSE(does_odometry_go_on(saved, {}, 60.0));
  EXPECT_FALSE(does_odometry_go_on({}, saved, 60.0));
}

}  // namespace
}  // namespace matchbox_slam
