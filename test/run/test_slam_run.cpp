#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "run/slam_run.hpp"
#include "slam/lost_robot.hpp"

namespace matchbox_slam {
namespace {

/// A run in a room, with a robot that is at rest.
class Run : public testing::Test {
 protected:
  static ScanInput scan(double stamp, int laser = 0) {
    ScanInput input;
    input.scan = to_laser_scan(make_scan(stamp));
    input.laser = laser;
    return input;
  }

  static Parameters change(const std::string& name, const ParameterValue& value) {
    Parameters parameters;
    parameters.set(name, value);
    return parameters;
  }

  MatcherLoader loader_;
  SlamRun run_{LiveConfiguration(parse_yaml_parameters("matcher: odometry_only", "test"), loader_)};
};

TEST_F(Run, ScansThatThereWasNoTimeForAreEventsInTheirPlaces) {
  (void)run_.process(scan(1.0));
  run_.apply(Reset{});
  run_.note_left_out(2.0, 1);
  run_.apply(Pause{false});
  (void)run_.process(scan(3.0));
  run_.note_left_out(4.0, 0);
  const std::vector<TimedEvent> events = run_.events();
  ASSERT_EQ(events.size(), 4U);
  EXPECT_TRUE(std::holds_alternative<Reset>(events[0].event));
  EXPECT_EQ(events[0].scan.stamp, 2.0) << "it came before the scan that was left out";
  EXPECT_TRUE(std::holds_alternative<LeaveOut>(events[1].event));
  EXPECT_EQ(events[1].scan.stamp, 2.0);
  EXPECT_EQ(events[1].scan.laser, 1);
  EXPECT_EQ(events[2].scan.stamp, 3.0);
  EXPECT_EQ(events[3].scan.stamp, 4.0) << "though no scan was used after it";
  SlamRun recent{LiveConfiguration({}, loader_), RunRecords::kRecent};
  recent.note_left_out(1.0, 0);
  EXPECT_TRUE(recent.events().empty());
}

TEST_F(Run, APoseOfALostRobotIsNotInTheMapUntilItIsFound) {
  (void)run_.process(scan(1.0));
  run_.begin_drive(2.0);
  const std::optional<ScanOutcome> lost = run_.process(scan(2.0));
  ASSERT_TRUE(lost);
  ASSERT_EQ(lost->state, TrackingState::kLost);
  EXPECT_TRUE(run_.is_in_map(1.0));
  EXPECT_FALSE(run_.is_in_map(2.0));
  run_.apply(SetPose{{}, Eigen::Matrix3d::Zero()});
  (void)run_.process(scan(3.0));
  EXPECT_FALSE(run_.is_in_map(2.0)) << "there it never was found";
  EXPECT_TRUE(run_.is_in_map(3.0));
  run_.apply(Reset{});
  EXPECT_TRUE(run_.is_in_map(2.0));
}

TEST_F(Run, LeavesScansOutWhilePaused) {
  ASSERT_TRUE(run_.process(scan(1.0)));
  run_.apply(Pause{true});
  EXPECT_FALSE(run_.process(scan(2.0)));
  run_.apply(Pause{false});
  EXPECT_TRUE(run_.process(scan(3.0)));
  ASSERT_EQ(run_.trajectory().size(), 2U);
  EXPECT_EQ(run_.trajectory().back().stamp, 3.0);
}

TEST_F(Run, TellsOfEachEventTheScanThatCameAfterIt) {
  run_.apply(SetPose{{1.0, 0.0, 0.0}, Eigen::Matrix3d::Zero()});
  (void)run_.process(scan(1.0));
  run_.apply(Pause{true});
  (void)run_.process(scan(2.0));
  run_.apply(Pause{false});
  run_.apply(Reset{});
  (void)run_.process(scan(3.0, 1));
  run_.jump_back();
  run_.apply(Reset{});
  (void)run_.process(scan(1.5));
  run_.apply(Reset{});  // no scan after it
  const std::vector<TimedEvent> events = run_.events();
  const std::vector<ScanMoment> moments = {
      {0, 1.0, 0}, {0, 2.0, 0}, {0, 3.0, 1}, {0, 3.0, 1}, {1, 1.5, 0}};
  ASSERT_EQ(events.size(), moments.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_FALSE(events[i].scan < moments[i] || moments[i] < events[i].scan) << i;
  }
  EXPECT_TRUE(std::get<Pause>(events[1].event).paused);
  EXPECT_EQ(run_.resets(), 4U);
}

TEST_F(Run, WhatATimeJumpUndidIsNoEventOfTheTimeAfterIt) {
  (void)run_.process(scan(5.0));
  run_.apply(SetPose{{7.0, 0.0, 0.0}, Eigen::Matrix3d::Zero()});
  run_.apply(Pause{true});
  run_.jump_back();
  (void)run_.process(scan(1.0));
  const std::vector<TimedEvent> events = run_.events();
  ASSERT_EQ(events.size(), 1U) << "the pose was told of a map that is given up";
  EXPECT_TRUE(std::holds_alternative<Pause>(events[0].event));
  EXPECT_EQ(events[0].scan.time_jumps, 1);
}

TEST_F(Run, KeepsNoEventsWhereOnlyRecentThingsAreKept) {
  SlamRun recent(run_.configuration(), RunRecords::kRecent);
  recent.apply(Pause{false});
  (void)recent.process(scan(1.0));
  EXPECT_TRUE(recent.events().empty());
}

TEST_F(Run, ACorrectedPoseKeepsTheMotionSince) {
  ScanInput moving = scan(1.0);
  moving.odometry = ScanOdometry{};
  (void)run_.process(moving);
  moving = scan(2.0);
  moving.odometry = ScanOdometry{{0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}};
  (void)run_.process(moving);
  run_.apply(CorrectPose{1.0, {10.0, 5.0, 1.5707963267948966}});
  moving = scan(3.0);
  moving.odometry = ScanOdometry{{0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}};
  const std::optional<ScanOutcome> outcome = run_.process(moving);
  ASSERT_TRUE(outcome);
  EXPECT_NEAR(outcome->map_from_base.x, 10.0, 1e-9);
  EXPECT_NEAR(outcome->map_from_base.y, 5.5, 1e-9);
}

TEST_F(Run, ACorrectionOfAPoseInAMapThatWasGivenUpIsRefused) {
  (void)run_.process(scan(1.0));
  run_.apply(Reset{});
  (void)run_.process(scan(2.0));
  const std::string text = error_text<std::runtime_error>([&] {
    run_.apply(CorrectPose{1.0, {10.0, 5.0, 0.0}});
  });
  EXPECT_TRUE(contains(text, "no scan of 1.000000 s was used for this map")) << text;
  EXPECT_LT(run_.process(scan(3.0))->map_from_base.x, 1.0);
}

TEST_F(Run, ACorrectionOfAPoseBeforeOneThatWasToldIsRefused) {
  (void)run_.process(scan(1.0));
  (void)run_.process(scan(2.0));
  run_.apply(SetPose{{50.0, 0.0, 0.0}, Eigen::Matrix3d::Zero()});
  EXPECT_NO_THROW(run_.apply(CorrectPose{2.0, {50.0, 0.0, 0.0}})) << "no scan came since";
  (void)run_.process(scan(3.0));
  for (const double stamp : {1.0, 2.0}) {
    EXPECT_TRUE(contains(error_text<std::runtime_error>([&] {
                           run_.apply(CorrectPose{stamp, {10.0, 5.0, 0.0}});
                         }),
                         "where it was has been told since"))
        << stamp;
  }
  run_.apply(CorrectPose{3.0, {10.0, 5.0, 0.0}});
  EXPECT_EQ(run_.process(scan(4.0))->map_from_base.x, 10.0);
}

TEST_F(Run, PutsPosesRightWhenALostRobotIsFound) {
  const SimulatedRun drive = perfect_drive();
  SlamRun run{LiveConfiguration(parse_yaml_parameters("matcher: olson", "test"), loader_)};
  run.start_from(lost_in(map_of(drive), drive.world_from_base.front() * Pose2{0.4, -0.2, 0.1}));
  std::size_t i = 0;
  while (i < drive.scans.size() && !run.process(scan_input(drive, i++))->joined) {
  }
  ASSERT_LT(i, drive.scans.size());
  ASSERT_EQ(run.trajectory().size(), i);
  for (std::size_t k = 0; k < i; ++k) {
    const Pose2 off = drive.world_from_base[k].inverse() * run.trajectory()[k].pose;
    EXPECT_LT(off.translation().norm(), 0.05) << k;
  }
  ASSERT_GT(run.path().poses().size(), 10U);
  for (const StampedPose2& pose : run.path().poses()) {
    const std::optional<Pose2> then = Trajectory(run.trajectory()).at(pose.stamp, 1.0);
    EXPECT_EQ(pose.pose, *then);
  }
}

TEST_F(Run, ReconfiguresWhatMayChangeAndKeepsThat) {
  (void)run_.process(scan(1.0));
  run_.apply(Reconfigure{change("matcher", std::string("hough"))});
  EXPECT_EQ(run_.setup().matcher_name, "matchbox_slam/Hough");
  run_.apply(Reset{});
  EXPECT_EQ(run_.setup().matcher_name, "matchbox_slam/Hough");
  EXPECT_TRUE(contains(error_text<ConfigurationError>([&] {
                         run_.apply(Reconfigure{change("base_frame", std::string("x"))});
                       }),
                       "base_frame: cannot be changed while running"));
  (void)run_.process(scan(2.0));
  EXPECT_EQ(run_.events().size(), 2U) << "what was refused is no event";
}

TEST(LaserText, OfOneThatIsNotUsedSaysWhichLeads) {
  const std::string text = text_of(SecondaryLaser{}, "/back");
  EXPECT_TRUE(contains(text, "the laser of /back is not used")) << text;
  EXPECT_TRUE(contains(text, "of scan_topics the first one leads")) << text;
}

TEST_F(Run, GoesOnWithALoadedMap) {
  for (const double stamp : {1.0, 2.0}) {
    (void)run_.process(scan(stamp));
  }
  EngineState saved = run_.snapshot();
  saved.begin_anew({0.5, 0.25, 0.0}, saved.motion.covariance);
  run_.apply(LoadMapFile{"office.slam", std::make_shared<const EngineState>(saved)});
  EXPECT_TRUE(run_.trajectory().empty());
  EXPECT_EQ(run_.key_scans().size(), saved.key_scans.size());
  const std::optional<ScanOutcome> outcome = run_.process(scan(3.0));
  EXPECT_NEAR(outcome->map_from_base.x, 0.5, 1e-9);
  EXPECT_EQ(std::get<LoadMapFile>(run_.events().front().event).map, nullptr)
      << "the record would hold its memory";
}

TEST_F(Run, APoseThatIsToldBeforeTheFirstScanOfASavedMapIsWhereTheRobotIs) {
  const SimulatedRun drive = perfect_drive();
  const std::size_t middle = drive.scans.size() / 2;
  for (const bool is_lost : {false, true}) {  // when it was saved
    EngineState saved = map_of(drive);
    if (is_lost) {
      saved = lost_in(std::move(saved), {3.0, 2.0, 1.0});
    }
    saved.motion.stamp = drive.scans[middle].stamp - 0.1;  // as if its drive went on
    SlamRun run{LiveConfiguration(parse_yaml_parameters("matcher: olson", "test"), loader_)};
    run.take_up_told(saved, {drive.world_from_base[middle] * Pose2{0.1, -0.05, 0.02},
                             0.01 * Eigen::Matrix3d::Identity()});
    const std::optional<ScanOutcome> outcome = run.process(scan_input(drive, middle));
    EXPECT_EQ(outcome->state, TrackingState::kTracking);
    EXPECT_LT(difference(outcome->map_from_base, drive.world_from_base[middle]).norm(), 0.01);
    EXPECT_EQ(run.parts_apart(), is_lost ? 1U : 0U);
    EXPECT_EQ(run.events().size(), 1U);
  }
}

}  // namespace
}  // namespace matchbox_slam
