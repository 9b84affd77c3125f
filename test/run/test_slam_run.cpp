#include <gtest/gtest.h>

#include <map>

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
  ASSERT_GT(run.path().poses().size(), 5U);
  for (const StampedPose2& pose : run.path().poses()) {
    const std::optional<Pose2> then = Trajectory(run.trajectory()).at(pose.stamp, 1.0);
    EXPECT_EQ(pose.pose, *then);
  }
}

TEST_F(Run, AComponentThatIsFoundInAnotherOneIsNotInTheMap) {
  const SimulatedRun drive = perfect_drive();
  EngineState start = map_of(drive);
  MapComponent found{std::move(start.map), std::move(start.key_scans), {}, 0.0};
  const EngineOptions options;
  start.map = SlamMap(options.map, options.field);  // in which nothing was seen yet
  start.key_scans = {};
  start.loops = {};
  start.local_map = {};
  start = lost_in(std::move(start), drive.world_from_base.front() * Pose2{0.4, -0.2, 0.1});
  start.localization.components.insert(start.localization.components.begin(), std::move(found));
  start.localization.active = 2;
  SlamRun run{LiveConfiguration(parse_yaml_parameters("matcher: olson", "test"), loader_)};
  run.start_from(std::move(start));
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const std::optional<ScanOutcome> outcome = run.process(scan_input(drive, i));
    ASSERT_EQ(outcome->state, TrackingState::kLost) << i;
    if (outcome->joined) {
      EXPECT_FALSE(run.is_in_map(drive.scans.front().stamp));
      EXPECT_FALSE(run.is_in_map(outcome->stamp));
      return;
    }
  }
  FAIL() << "it was never found";
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
    run.take_up_at(saved, {drive.world_from_base[middle] * Pose2{0.1, -0.05, 0.02},
                           0.01 * Eigen::Matrix3d::Identity()});
    const std::optional<ScanOutcome> outcome = run.process(scan_input(drive, middle));
    EXPECT_EQ(outcome->state, TrackingState::kTracking);
    EXPECT_LT(difference(outcome->map_from_base, drive.world_from_base[middle]).norm(), 0.01);
    EXPECT_EQ(run.disconnected_components(), is_lost ? 1U : 0U);
    EXPECT_EQ(run.events().size(), 1U);
  }
}

/// A drive whose clock steps back.
class Step : public Run {
 protected:
  SlamRun run_through(const std::string& options = "{}") const {
    SlamRun run{LiveConfiguration(parse_yaml_parameters(options, "test"), loader_)};
    for (std::size_t i = 0; i < drive_.scans.size() / 2; ++i) {
      (void)run.process(scan_input(drive_, i));
    }
    return run;
  }

  [[nodiscard]] ScanInput scan_at(std::size_t i, double moved) const {
    ScanInput input = scan_input(drive_, i);
    input.scan.stamp += moved;
    return input;
  }

  const SimulatedRun drive_ = perfect_drive();
  const std::size_t half_ = drive_.scans.size() / 2;
};

TEST_F(Step, TheMapGoesOnAndTheRobotIsNotLost) {
  for (const double back : {1.5, 7200.0}) {
    for (const bool updates_map : {true, false}) {
      SlamRun run = run_through();
      Parameters localising;
      localising.set("slam/update_map", updates_map);
      run.apply(Reconfigure{localising});
      const std::size_t key_scans = run.key_scans().size();
      const Pose2 map_from_world =
          run.trajectory().back().pose * drive_.world_from_base[half_ - 1].inverse();
      run.step_back();
      const std::size_t end = updates_map ? drive_.scans.size() : half_ + 40;  // where it is mapped
      for (std::size_t i = half_; i < end; ++i) {
        const std::optional<ScanOutcome> outcome = run.process(scan_at(i, -back));
        ASSERT_EQ(outcome->state, TrackingState::kTracking) << back << " s, scan " << i;
        ASSERT_LT(difference(outcome->map_from_base, map_from_world * drive_.world_from_base[i])
                      .head<2>()
                      .norm(),
                  0.01)
            << back << " s, scan " << i << ", " << updates_map;
      }
      EXPECT_EQ(run.key_scans().size() > key_scans, updates_map);
      EXPECT_EQ(run.resets(), 0U);
      EXPECT_EQ(run.clock_steps(), 1U);
      const auto parts = run.by_clock(run.trajectory());
      ASSERT_EQ(parts.size(), 2U);
      EXPECT_EQ(parts[0].size(), half_);
      ASSERT_EQ(parts[1].size(), end - half_);
      EXPECT_NEAR(parts[1].front().stamp, drive_.scans[half_].stamp - back, 1e-6);
      EXPECT_NEAR(*run.snapshot().motion.stamp, drive_.scans[end - 1].stamp - back, 1e-6);
    }
  }
}

TEST_F(Step, ABagThatIsPlayedAgainIsAnotherDriveInTheSameMap) {
  SlamRun run = run_through();
  const std::size_t key_scans = run.key_scans().size();
  const Pose2 map_from_world =
      run.trajectory().back().pose * drive_.world_from_base[half_ - 1].inverse();
  run.step_back();
  bool was_found = false;
  ScanOutcome outcome;
  for (std::size_t i = 0; i < half_; ++i) {
    outcome = *run.process(scan_at(i, 0.0));
    EXPECT_TRUE(i > 0 || outcome.state == TrackingState::kLost);
    was_found = was_found || outcome.joined;
  }
  EXPECT_TRUE(was_found);
  EXPECT_GE(run.key_scans().size(), key_scans);
  EXPECT_LT(difference(outcome.map_from_base, map_from_world * drive_.world_from_base[half_ - 1])
                .head<2>()
                .norm(),
            0.02);
  const auto parts = run.by_clock(run.trajectory());
  ASSERT_EQ(parts.size(), 2U);
  for (std::size_t i = 0; i < half_; ++i) {  // put right when it was found, in its part alone
    for (const auto& part : parts) {
      EXPECT_LT(
          difference(part[i].pose, map_from_world * drive_.world_from_base[i]).head<2>().norm(),
          0.02)
          << i;
    }
  }
}

TEST_F(Step, WithoutOdometryALongOneIsAPause) {
  for (const auto& [back, state] : std::map<double, TrackingState>{{1.5, TrackingState::kTracking},
                                                                   {60.0, TrackingState::kLost}}) {
    SlamRun run = run_through();
    run.step_back();
    ScanInput input = scan_at(half_, -back);
    input.odometry.reset();
    EXPECT_EQ(run.process(input)->state, state) << back;
  }
}

TEST_F(Step, APoseThatWasToldBeforeItHolds) {
  SlamRun run = run_through();
  const Pose2 map_from_world =
      run.trajectory().back().pose * drive_.world_from_base[half_ - 1].inverse();
  run.apply(
      SetPose{map_from_world * drive_.world_from_base.front(), 0.01 * Eigen::Matrix3d::Identity()});
  run.step_back();
  ScanInput input = scan_at(0, 0.0);
  input.odometry.reset();
  const std::optional<ScanOutcome> outcome = run.process(input);
  EXPECT_EQ(outcome->state, TrackingState::kTracking);
  EXPECT_LT(difference(outcome->map_from_base, map_from_world * drive_.world_from_base.front())
                .head<2>()
                .norm(),
            0.05);
}

TEST_F(Step, ACorrectionNamesScansByTheClockOfNow) {
  SlamRun run = run_through();
  run.step_back();
  (void)run.process(scan_at(half_, -1.5));
  const double stamp = drive_.scans[half_].stamp - 1.5;
  EXPECT_NO_THROW(run.apply(CorrectPose{stamp, {3.0, 4.0, 0.5}}));
  EXPECT_TRUE(contains(error_text<std::runtime_error>([&] {
                         run.apply(CorrectPose{drive_.scans[1].stamp, {}});
                       }),
                       "no scan of"));
}

TEST_F(Step, AMapThatIsGoneOnWithAfterItHasStampsThatGoOn) {
  SlamRun run = run_through();
  run.step_back();
  std::size_t i = half_;
  for (; i < half_ + 20; ++i) {
    (void)run.process(scan_at(i, -1000.0));
  }
  SlamRun next{LiveConfiguration({}, loader_)};
  EXPECT_TRUE(next.take_up(run.snapshot(), drive_.scans[i].stamp - 1000.0, 10.0));
  EXPECT_EQ(next.process(scan_at(i, -1000.0))->state, TrackingState::kTracking);
  EXPECT_GT(next.trajectory().back().stamp, next.key_scans().all().front().scan->stamp());
  EXPECT_NEAR(next.by_clock(next.trajectory()).back().back().stamp, drive_.scans[i].stamp - 1000.0,
              1e-6);
}

TEST_F(Step, ARobotThatMayBeAnywhereIsSearchedFor) {
  SlamRun run = run_through();
  run.apply(BeAnywhere{});
  EXPECT_EQ(run.process(scan_at(half_, 0.0))->state, TrackingState::kLost);
  std::size_t i = half_ + 1;
  while (i < drive_.scans.size() && !run.process(scan_at(i, 0.0))->joined) {
    ++i;
  }
  ASSERT_LT(i, drive_.scans.size());
  const std::vector<WeightedPose> likely = run.likely_poses();
  ASSERT_EQ(likely.size(), 1U);
  EXPECT_EQ(likely.front().map_from_base, run.trajectory().back().pose);
  EXPECT_EQ(likely.front().weight, 1.0);
  SlamRun empty{LiveConfiguration({}, loader_)};
  EXPECT_TRUE(contains(error_text<std::runtime_error>([&] { empty.apply(BeAnywhere{}); }),
                       "there are no key scans to search for the robot in"));
}

}  // namespace
}  // namespace matchbox_slam
