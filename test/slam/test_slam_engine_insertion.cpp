// Of slam/slam_engine.hpp: which scans the map takes in.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/engine_runs.hpp"

namespace matchbox_slam {
namespace {

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

}  // namespace
}  // namespace matchbox_slam
