// Of slam/slam_engine.hpp and slam/engine_state.hpp: what an engine makes of doubts and losses that
// it is told of: a map start says all that it knows.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/lost_robot.hpp"
#include "slam/pose_distance.hpp"

namespace matchbox_slam {
namespace {

/// A room of 2 m around a robot at rest, which believes its odometry: nothing of it confirms.
class LocalizationStateTest : public testing::Test {
 protected:
  LocalizationStateTest() {
    engine_.process(scan());
    start_ = engine_.snapshot();
  }

  /// One that is longer than the room is contradicts it.
  ScanInput scan(float range = 2.0F) {
    ScanInput input;
    input.scan = {stamp_ += 0.1, -3.0, 0.01, 0.0, 0.1, 10.0, std::vector<float>(600, range)};
    input.odometry = ScanOdometry{};
    return input;
  }

  /// A scan of the map, to wait in a component of it.
  WaitingScan waiting(std::size_t component) { return {component, start_.key_scans.all().front()}; }

  MapComponent component(double begin) {
    return {SlamMap(engine_.options().map, engine_.options().field), {}, {}, begin};
  }

  /// Goes on from what is told for some scans.
  ScanOutcome go_on(int scans = 1, float range = 2.0F) {
    engine_.start_from(start_);
    ScanOutcome outcome;
    for (int i = 0; i < scans; ++i) {
      outcome = engine_.process(scan(range));
    }
    return outcome;
  }

  /// As likely as where it is, the robot is a metre away.
  void be_in_doubt() {
    start_.localization.hypotheses.fork = HypothesesFork{1};
    start_.localization.hypotheses.others = {{{1.0, 0.0, 0.0}, 0.0}};
  }

  [[nodiscard]] LocalizationState now() { return engine_.snapshot().localization; }

  double stamp_ = 100.0;
  SlamEngine engine_{{}, std::make_shared<OdometryOnlyMatcher>(), 1};
  EngineState start_{SlamMap({}, {}), {}, {}, {}, 0};
};

TEST_F(LocalizationStateTest, WhatWaitsIsInsertedTwoWithEachScan) {
  start_.localization.pending.assign(3, waiting(0));
  EXPECT_EQ(go_on().state, TrackingState::kRecovered);
  EXPECT_EQ(engine_.key_scans().size(), 3U);
  EXPECT_EQ(engine_.process(scan()).state, TrackingState::kTracking);
  EXPECT_EQ(engine_.key_scans().size(), 4U);
}

TEST_F(LocalizationStateTest, WhatWaitsAndHasNoRoomIsToldAndDropped) {
  WaitingScan wild = waiting(0);
  wild.scan.map_from_base = {1e7, 1e7, 0.0};
  start_.localization.pending.assign(3, wild);
  EXPECT_EQ(go_on().left_out, 2U);
  EXPECT_EQ(engine_.process(scan()).left_out, 1U);
  EXPECT_TRUE(now().pending.empty());
  EXPECT_EQ(engine_.key_scans().size(), 1U);
}

TEST_F(LocalizationStateTest, WhatWaitsIsNotInsertedWhileTheRobotMayBeElsewhere) {
  be_in_doubt();
  start_.localization.pending.assign(3, waiting(0));
  EXPECT_EQ(go_on(5).state, TrackingState::kDoubt);
  EXPECT_EQ(engine_.key_scans().size(), 1U);
  EXPECT_EQ(now().pending.size(), 3U);
}

TEST_F(LocalizationStateTest, WhatWaitsForAMapThatIsNotToChangeGoesOnWaiting) {
  EngineOptions options;
  options.slam.update_map = false;
  engine_.set_options(options);
  start_.localization.pending.assign(3, waiting(0));
  EXPECT_EQ(go_on(5).state, TrackingState::kTracking);
  EXPECT_EQ(engine_.key_scans().size(), 1U);
  EXPECT_EQ(now().pending.size(), 3U);
}

TEST_F(LocalizationStateTest, WhatWaitsForAnotherComponentGoesOnWaiting) {
  start_.localization.components.push_back(component(0.0));
  start_.localization.pending = {waiting(1), waiting(0)};
  EXPECT_EQ(go_on(5).state, TrackingState::kTracking);
  EXPECT_EQ(engine_.key_scans().size(), 2U);
  ASSERT_EQ(now().pending.size(), 1U);
  EXPECT_EQ(now().pending.front().component, 1U);
  EXPECT_TRUE(now().components.front().key_scans.empty());
}

TEST_F(LocalizationStateTest, ADoubtEndsWhereNoneIsAllowed) {
  be_in_doubt();
  EXPECT_EQ(go_on().state, TrackingState::kDoubt);
  EngineOptions options;
  options.hypotheses.enabled = false;
  engine_.set_options(options);
  EXPECT_EQ(engine_.state(), TrackingState::kTracking);
  EXPECT_FALSE(now().hypotheses.fork);
  EXPECT_EQ(engine_.process(scan()).state, TrackingState::kTracking);
}

TEST_F(LocalizationStateTest, ADoubtIsToldByTheCovariance) {
  const double sure = go_on().covariance(0, 0);
  be_in_doubt();
  EXPECT_NEAR(go_on().covariance(0, 0) - sure, 0.5, 0.01) << "half of the odds, a metre away";
}

TEST_F(LocalizationStateTest, AComponentThatIsBegunAnewForgetsWhatWaitedForIt) {
  start_.localization.components = {component(7.0)};
  start_.localization.active = 1;
  start_.localization.pending = {waiting(0), waiting(1)};
  engine_.start_from(start_);
  EXPECT_FALSE(engine_.begin_component(stamp_));
  EXPECT_EQ(engine_.process(scan()).state, TrackingState::kLost);
  ASSERT_EQ(now().components.size(), 1U) << "it held nothing that is worth keeping";
  EXPECT_EQ(now().components.front().begin, 7.0) << "poses since then are of it";
  ASSERT_EQ(now().pending.size(), 1U);
  EXPECT_EQ(now().pending.front().component, 0U);
}

/// Of 16 components, where the third has the fewest key scans.
TEST_F(LocalizationStateTest, TheSmallestOfTooManyComponentsIsGivenUp) {
  for (std::size_t i = 0; i < kMostDisconnectedComponents; ++i) {
    start_.localization.components.push_back(component(static_cast<double>(i)));
    start_.localization.components.back().parent = i;
    start_.localization.components.back().parent_from_component = {1.0, 0.0, 0.0};
    for (int k = 0; k < (i == 2 ? 3 : 4); ++k) {
      start_.localization.components.back().key_scans.add(start_.key_scans.all().front());
    }
  }
  start_.localization.active = kMostDisconnectedComponents;
  start_.localization.pending = {waiting(0), waiting(3), waiting(4)};
  engine_.start_from(start_);
  EXPECT_TRUE(engine_.begin_component(stamp_));
  engine_.process(scan());
  ASSERT_EQ(now().components.size(), kMostDisconnectedComponents);
  EXPECT_EQ(now().active, kMostDisconnectedComponents);
  EXPECT_EQ(now().components[1].begin, 1.0);
  EXPECT_EQ(now().components[2].begin, 3.0);
  EXPECT_EQ(now().components[2].parent, 2U) << "what the one that is given up had left";
  EXPECT_EQ(now().components[2].parent_from_component, (Pose2{2.0, 0.0, 0.0}));
  EXPECT_EQ(now().components[15].parent, 15U) << "the newest one, which the robot has just left";
  ASSERT_EQ(now().pending.size(), 2U);
  EXPECT_EQ(now().pending[0].component, 0U);
  EXPECT_EQ(now().pending[1].component, 3U);
}

TEST_F(LocalizationStateTest, APoseThatIsToldLeavesComponentsBehind) {
  start_.localization.components = {component(7.0)};
  start_.localization.active = 1;
  start_.localization.pending = {waiting(1)};
  EXPECT_EQ(go_on().state, TrackingState::kLost);
  engine_.set_pose({}, 0.01 * Eigen::Matrix3d::Identity());
  EXPECT_EQ(engine_.state(), TrackingState::kTracking);
  EXPECT_EQ(engine_.disconnected_components(), 1U);
  EXPECT_TRUE(now().pending.empty());
  EXPECT_GT(now().components.front().begin, stamp_) << "poses since then are not of it";
}

TEST_F(LocalizationStateTest, BegunAnewNothingIsInDoubtNorSearched) {
  start_.localization.components = {component(7.0)};
  start_.localization.active = 1;
  be_in_doubt();
  start_.localization.search.hypotheses = {{}};
  start_.begin_anew({}, Eigen::Matrix3d::Identity());
  EXPECT_EQ(start_.localization.active, 0U);
  EXPECT_FALSE(start_.localization.hypotheses.fork);
  EXPECT_TRUE(start_.localization.hypotheses.others.empty());
  EXPECT_TRUE(start_.localization.search.hypotheses.empty());
  EXPECT_EQ(start_.localization.components.size(), 1U) << "what was mapped stays";
}

// --- with something to see ---

/// Where a lost robot is found on a drive, with what became of the scan that finds it.
struct Found {
  std::size_t scan = 0;
  ScanOutcome outcome;
};

Found find(const SimulatedRun& run, const EngineState& start) {
  SlamEngine engine({}, std::make_shared<OlsonMatcher>(), 1);
  engine.start_from(start);
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const ScanOutcome outcome = engine.process(scan_input(run, i));
    if (outcome.joined) {
      return {i, outcome};
    }
  }
  ADD_FAILURE() << "not found";
  return {};
}

/// An image of a map has no key scans, and this map is small: odometry says where to look.
TEST(LostRobot, IsFoundWhereThereAreNoKeyScans) {
  const SimulatedRun run = perfect_drive();
  EngineState image = map_of(run);
  image.key_scans = {};
  const Found found = find(run, lost_in(image, run.world_from_base.front() * Pose2{0.3, 0.2, 0.1}));
  EXPECT_LT(distance(found.outcome.map_from_base, run.world_from_base[found.scan]), 0.02);
  EXPECT_LT(distance(found.outcome.predicted_map_from_base, run.world_from_base[found.scan]), 0.1);
  EXPECT_EQ(found.outcome.joined->begin, 0.0);
  EXPECT_GE(found.outcome.covariance(0, 0), 0.01);
}

/// Odometry tells where to look in the component that the robot left, in that one's frame, and
/// nothing of others.
TEST(LostRobot, IsLookedForWhereOdometrySaysInTheComponentThatItLeft) {
  const SimulatedRun run = perfect_drive();
  const EngineState map = map_of(run);
  const auto search_after = [&](std::size_t parent) {
    EngineState start = lost_in(map, {});
    start.localization.components.push_back(start.localization.components.front());
    start.localization.components.front().parent = parent;
    start.localization.components.front().parent_from_component =
        parent == 1 ? Pose2{} : run.world_from_base[0];
    start.key_scans = {};
    SlamEngine engine({}, std::make_shared<OlsonMatcher>(), 1);
    engine.start_from(start);
    engine.process(scan_input(run, 0));
    engine.process(scan_input(run, 1));
    return engine.snapshot().localization.search;
  };
  ASSERT_EQ(search_after(0).hypotheses.size(), 1U);
  EXPECT_LT(distance(search_after(0).hypotheses.front().component_from_active,
                     run.world_from_base.front()),
            0.02);
  EXPECT_TRUE(search_after(2).hypotheses.empty()) << "where nothing is mapped";
  EXPECT_TRUE(search_after(1).hypotheses.empty()) << "in itself";
}

/// Stamps are no whole numbers of intervals: none of the scans is passed over.
TEST(LostRobot, IsSearchedForWithEachScanThatComesAnIntervalAfterTheOneBefore) {
  const SimulatedRun run = perfect_drive();
  const EngineState start = lost_in(map_of(run), run.world_from_base.front());
  EngineOptions options;
  options.recovery.interval = run.scans[1].stamp - run.scans[0].stamp + 1e-6;
  SlamEngine engine(options, std::make_shared<OlsonMatcher>(), 1);
  engine.start_from(start);
  engine.process(scan_input(run, 0));  // begins the component
  for (std::size_t i = 1; i < 4; ++i) {
    engine.process(scan_input(run, i));
    EXPECT_EQ(engine.snapshot().localization.search.stamp, run.scans[i].stamp);
  }
}

}  // namespace
}  // namespace matchbox_slam
