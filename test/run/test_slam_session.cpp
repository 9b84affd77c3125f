#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "run/slam_session.hpp"
#include "run/start_map.hpp"
#include "slam/lost_robot.hpp"

namespace matchbox_slam {
namespace {

ScanInput scan(double stamp, std::size_t beams = 90) {
  ScanInput input;
  input.scan = to_laser_scan(make_scan(stamp, "laser", beams));
  return input;
}

/// What is heard of a session in a room, with a robot that is at rest.
class Session : public testing::Test {
 protected:
  [[nodiscard]] SlamSession session(const std::string& options = "{}") {
    return {LiveConfiguration(
                parse_yaml_parameters("{matcher: odometry_only, " + options.substr(1), "test"),
                loader_),
            RunRecords::kAll, dialog_, "give --set "};
  }

  /// As of scans of these stamps [s], with the robot at x = 0.5 m, 0.25 m after the last one.
  EngineState saved(const std::vector<double>& stamps) {
    SlamSession past = session();
    for (const double stamp : stamps) {
      (void)past.process(scan(stamp));
    }
    EngineState state = past.run().snapshot();
    state.motion.fixed_from_base = {0.5, 0.25, 0.0};
    return state;
  }

  [[nodiscard]] LoadMapFile loaded() {
    EngineState state = saved({1.0, 2.0});
    state.begin_anew(state.motion.fixed_from_base, initial_pose_covariance());
    return {"office.slam", std::make_shared<const EngineState>(std::move(state))};
  }

  MatcherLoader loader_;
  std::vector<std::string> informs_;
  std::vector<std::string> warnings_;
  const RunDialog dialog_{[this](const std::string& line) { informs_.push_back(line); },
                          [this](const std::string& line) { warnings_.push_back(line); },
                          [](double, const std::string&) {}, [] { return false; }};
};

TEST_F(Session, GoesOnWithASavedMapWhoseDriveGoesOn) {
  SlamSession now = session();
  now.go_on_with({saved({1.0, 2.0}), "old.slam"});
  EXPECT_GT(now.run().key_scans().size(), 0U) << "it is to be seen before a scan comes";
  EXPECT_TRUE(informs_.empty());
  const std::optional<ScanOutcome> outcome = now.process(scan(3.0));
  EXPECT_EQ(outcome->state, TrackingState::kTracking);
  EXPECT_EQ(outcome->map_from_base.x, 0.5);
  (void)now.process(scan(4.0));
  ASSERT_EQ(informs_.size(), 1U);
  EXPECT_EQ(informs_.front(),
            "going on with old.slam, whose drive goes on after its scan of 2.000 s with that of "
            "3.000 s");
}

TEST_F(Session, OfAnotherDriveTheRobotIsSearchedForInTheSavedMap) {
  SlamSession now = session();
  now.go_on_with({saved({1.0, 2.0}), "old.slam"});
  EXPECT_EQ(now.process(scan(102.0))->state, TrackingState::kLost);
  ASSERT_EQ(informs_.size(), 1U);
  EXPECT_TRUE(contains(informs_.front(),
                       "this is another drive, as its first scan is 100.000 s newer than the last "
                       "one of the map: the robot is searched for"))
      << informs_.front();
}

TEST_F(Session, OdometryTellsOfTheDriveOnlyWhereItMay) {
  ScanInput far = scan(1.0);
  far.odometry = ScanOdometry{{5.0, 0.0, 0.0}, {5.0, 0.0, 0.0}};
  SlamSession past = session();
  (void)past.process(far);
  const EngineState saved = past.run().snapshot();
  for (const bool may : {false, true}) {
    SlamSession now = session();
    now.go_on_with({saved, "old.slam", may});
    far.scan.stamp = 101.0;
    EXPECT_EQ(now.process(far)->state, may ? TrackingState::kTracking : TrackingState::kLost);
  }
}

TEST_F(Session, APoseToldBeforeTheFirstScanIsInTheSavedMap) {
  SlamSession now = session();
  now.go_on_with({saved({1.0, 2.0}), "old.slam"});
  now.apply(Pause{false});  // neither settles where it is
  now.apply(SetPose{{7.0, 2.0, 0.0}, initial_pose_covariance()});
  const std::optional<ScanOutcome> outcome = now.process(scan(102.0));
  EXPECT_EQ(outcome->state, TrackingState::kTracking);
  EXPECT_EQ(outcome->map_from_base.x, 7.0);
  EXPECT_EQ(informs_, std::vector<std::string>{
                          "going on with old.slam; where the robot is in it has been told"});
}

TEST_F(Session, ASavedMapThatIsGivenUpBeforeTheFirstScanIsNotGoneOnWith) {
  SlamSession now = session();
  now.go_on_with({saved({1.0, 2.0}), "old.slam"});
  now.apply(Reset{});
  EXPECT_EQ(now.process(scan(3.0))->map_from_base.x, 0.0);
  EXPECT_TRUE(informs_.empty());
}

TEST_F(Session, BeginsWithALoadedMapEachTimeThatOneIsGivenUp) {
  SlamSession now = session("{time_jump: reset}");
  now.begin_with(loaded());
  EXPECT_EQ(now.process(scan(3.0))->map_from_base.x, 0.5);
  EXPECT_TRUE(now.jump_back("time jumps back: ", false));
  EXPECT_EQ(warnings_, std::vector<std::string>{
                           "time jumps back: starting a new map, as time_jump is 'reset'"});
  EXPECT_EQ(now.process(scan(1.0))->map_from_base.x, 0.5);
  ASSERT_EQ(now.beginning().size(), 1U);
  EXPECT_TRUE(std::holds_alternative<LoadMapFile>(now.beginning().front()));
  EXPECT_TRUE(std::holds_alternative<Reset>(session().beginning().front()));
}

TEST_F(Session, ASavedMapGoesBeforeTheOneThatItBeginsWith) {
  SlamSession now = session();
  now.go_on_with({saved({1.0}), "old.slam"});
  now.begin_with(loaded());
  EXPECT_EQ(now.run().resets(), 0U);
  EXPECT_TRUE(std::holds_alternative<LoadMapFile>(now.beginning().front()));
}

TEST_F(Session, ARobotThatIsOnlyLocalisedIsSearchedForUnlessItsStartIsGiven) {
  for (const bool is_given : {false, true}) {
    SlamSession now =
        session(std::string("{slam/update_map: false") + (is_given ? ", start_y: 0.0}" : "}"));
    now.begin_with(loaded());
    const TrackingState expected = is_given ? TrackingState::kTracking : TrackingState::kLost;
    EXPECT_EQ(now.process(scan(3.0))->state, expected);
    // As at the start, too, when the map is given up, by ~reset or a jump of time.
    for (const RunEvent& event : now.beginning()) {
      now.apply(event);
    }
    EXPECT_EQ(now.process(scan(4.0))->state, expected) << is_given;
  }
}

TEST_F(Session, AScanOfAPauseDoesNotSettleWhichDriveGoesOn) {
  SlamSession now = session();
  now.go_on_with({saved({1.0}), "old.slam"});
  now.apply(Pause{true});
  (void)now.process(scan(2.0));
  EXPECT_TRUE(informs_.empty());
  now.apply(Pause{false});
  (void)now.process(scan(2.5));
  ASSERT_FALSE(informs_.empty());
  EXPECT_NE(informs_.front().find("going on with old.slam"), std::string::npos);
}

TEST_F(Session, AfterAJumpOfTimeTheMapGoesOnOrItIsTheEnd) {
  SlamSession now = session();
  (void)now.process(scan(5.0));
  EXPECT_FALSE(now.jump_back("time jumps back: ", false));
  (void)now.process(scan(1.0));
  EXPECT_EQ(now.run().clock_steps(), 1U);
  EXPECT_EQ(now.run().resets(), 0U);
  EXPECT_FALSE(now.jump_back("time jumps back: ", true));
  EXPECT_EQ(warnings_,
            (std::vector<std::string>{"time jumps back: the map goes on, as time_jump is 'go_on'; "
                                      "with 'reset' a new one begins",
                                      "time jumps back: stopping there, as time_jump is 'stop'"}));
}

TEST_F(Session, CutsBeamsThatReadTheLargestRangePlusNoise) {
  SlamSession now = session();
  const std::vector<RunEvent> before = now.cut_no_returns(29.9, false);
  ASSERT_EQ(before.size(), 1U);
  now.apply(before.front());
  EXPECT_EQ(now.setup().engine.scan.max_range, 29.9);
  EXPECT_TRUE(now.cut_no_returns(29.8, false).empty()) << "it is set by now";
  SlamSession begun = session();
  const std::vector<RunEvent> events = begun.cut_no_returns(29.9, true);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<Reset>(events.back()));
  SlamSession continued = session();
  continued.go_on_with({saved({1.0}), "old.slam"});
  EXPECT_EQ(continued.cut_no_returns(29.9, true).size(), 1U);
  const std::string cut =
      "where they meet nothing, beams of a laser read one range plus noise; scan/max_range is "
      "set to 29.900 m, from which on they are no return";
  EXPECT_EQ(warnings_, (std::vector<std::string>{cut, cut + ", and the map begins anew", cut}));
}

TEST_F(Session, CutsNoBeamsThatSomebodyWantsOrOfOneLaserAmongSeveral) {
  EXPECT_TRUE(session("{scan/max_range: 40.0}").cut_no_returns(29.9, true).empty());
  EXPECT_TRUE(warnings_.empty());
  EXPECT_TRUE(session("{scan_topics: [a, b]}").cut_no_returns(29.9, true).empty());
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(contains(warnings_.front(), "to cut them give --set scan/max_range=29.900"))
      << warnings_.front();
}

TEST_F(Session, CutsBeamsAsInTheMapThatItGoesOnWith) {
  SlamSession past = session("{scan/max_range: 29.9}");
  (void)past.process(scan(1.0));
  const SavedStart saved{past.run().snapshot(), "old.slam"};
  SlamSession now = session();
  now.go_on_with(saved);
  (void)now.process(scan(2.0));
  EXPECT_EQ(now.setup().engine.scan.max_range, 29.9);
  ASSERT_EQ(informs_.size(), 2U);
  EXPECT_EQ(informs_.back(),
            "scan/max_range is set to 29.900 m, as for the scans of the same laser in the map; for "
            "another value give --set scan/max_range=VALUE");
  EXPECT_TRUE(now.cut_no_returns(29.8, true).empty()) << "nor is it looked for again";
  ASSERT_EQ(now.run().events().size(), 1U) << "it can be repeated";
  EXPECT_TRUE(std::holds_alternative<Reconfigure>(now.run().events().front().event));

  SlamSession loaded = session();
  loaded.apply(LoadMapFile{"old.slam", std::make_shared<const EngineState>(saved.map)});
  (void)loaded.process(scan(2.0));
  EXPECT_EQ(loaded.setup().engine.scan.max_range, 29.9);

  SlamSession wanted = session("{scan/max_range: 40.0}");
  wanted.go_on_with(saved);
  (void)wanted.process(scan(2.0));
  EXPECT_EQ(wanted.setup().engine.scan.max_range, 40.0);

  ScanInput of_another_laser = scan(2.0);
  of_another_laser.scan.range_max = 50.0;
  SlamSession other = session();
  other.go_on_with(saved);
  (void)other.process(of_another_laser);
  EXPECT_EQ(other.setup().engine.scan.max_range, ProjectionOptions{}.max_range);
}

TEST_F(Session, TellsOnceThatScansHaveFewReturns) {
  SlamSession now = session();
  for (int i = 0; i < 300; ++i) {
    (void)now.process(scan(0.1 * i, 20));
    now.advise();
  }
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_EQ(warnings_.front(), now.few_returns());
  EXPECT_TRUE(contains(warnings_.front(), "scans have 20 returns")) << warnings_.front();
  EXPECT_EQ(now.robot_beams(), "");
}

TEST_F(Session, TellsOfAnotherDrive) {
  SlamSession now = session();
  (void)now.process(scan(1.0));
  now.begin_drive(2.0);
  EXPECT_EQ(now.process(scan(2.0))->state, TrackingState::kLost);
  EXPECT_EQ(informs_, std::vector<std::string>{
                          "another drive begins after 1 scans: the robot is searched for in the "
                          "map"});
}

}  // namespace
}  // namespace matchbox_slam
