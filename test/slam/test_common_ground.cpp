#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "slam/common_ground.hpp"
#include "slam/scan_evidence.hpp"
#include "slam/wall_scan.hpp"

namespace matchbox_slam {
namespace {

TEST(CommonGround, FollowsAScanThatIsKnownWherePredictionsAreWrong) {
  const World world = make_world("rooms", 2);
  LaserOptions laser;
  laser.beams = 360;
  const MatchScene scene = make_match_scene(world, laser, 20.0, 2);
  const OlsonMatcher matcher;
  CommonGroundMatch common;
  for (const Eigen::Vector3d& off :
       {Eigen::Vector3d(0.4, 0.0, 0.0), Eigen::Vector3d(0.0, -0.4, 0.1),
        Eigen::Vector3d(-0.3, 0.3, -0.15)}) {
    const MatchProblem problem =
        scene.problem(shifted(scene.map_from_base, off), prior_of(0.3, 0.1));
    const MatchResult found = common.match(matcher, problem, scene.map);
    EXPECT_LT(shift_between(scene.map_from_base, found.map_from_base).head<2>().norm(), 0.01);
  }
}

/// Finds a scan of so many points at a pose, and one of fewer nowhere.
class MatcherOfWholeScans : public ScanMatcher {
 public:
  MatcherOfWholeScans(std::size_t points, const Pose2& answer) : points_(points), answer_(answer) {}
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    if (problem.scan.points.size() < points_) {
      return rejected(problem, MatchStatus::kRejectedTooFewPoints);
    }
    MatchResult result = rejected(problem, MatchStatus::kAccepted);
    result.map_from_base = answer_;
    result.score = 0.5;
    result.covariance = Eigen::Vector3d(1e-4, 1e-5, 1e-6).asDiagonal();
    return result;
  }

 private:
  std::size_t points_;
  Pose2 answer_;
};

/// Along a wall nothing tells how far it is but where the known part ends, which is no end.
TEST(CommonGround, LeavesItToOdometryWhereNothingElseTells) {
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  insert_scan(wall_between(-2.0, 0.0), {}, {}, map);
  const PointScan scan = wall_between(-0.6, 1.4);
  const PlacedScans none;
  const Pose2 odometry{0.7, 0.0, 0.0};
  const MatchProblem problem{scan, odometry, prior_of(0.3, 0.02), map.field, none, 1};
  const MatcherOfWholeScans drawn(scan.points.size(), {0.2, 0.001, 0.0});
  const MatchResult match = CommonGroundMatch().match(drawn, problem, map);
  EXPECT_TRUE(match.accepted());
  EXPECT_NEAR(match.map_from_base.x, odometry.x, 1e-9);
  EXPECT_NEAR(match.map_from_base.y, 0.001, 1e-9) << "across the wall it is as matched";
  EXPECT_NEAR(match.covariance(0, 0), 0.3 * 0.3 + 1e-4, 1e-9) << "known no better";
  EXPECT_NEAR(match.covariance(1, 1), 1e-5, 1e-9);
}

/// Finds a scan of so many points at one pose, and one of fewer at another.
class MatcherOfTwoMinds : public MatcherOfWholeScans {
 public:
  MatcherOfTwoMinds(std::size_t points, const Pose2& of_whole, const Pose2& of_part)
      : MatcherOfWholeScans(points, of_whole), of_part_(0, of_part) {}
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    const MatchResult whole = MatcherOfWholeScans::match(problem);
    return whole.accepted() ? whole : of_part_.match(problem);
  }

 private:
  MatcherOfWholeScans of_part_;
};

/// Of two walls one tells nothing of how far it is along it; what is left shows the other, of which
/// more is known further along that one.
TEST(CommonGround, IsNotDrawnByWhatIsLeftOfTheScan) {
  const auto two_walls = [](double from, double to, double from_y, double to_y, double x) {
    PointScan scan = wall_between(from, to);
    for (double y = from_y; y <= to_y; y += 0.05) {
      ScanPoint point{{x, y}};
      point.normal = {-1.0, 0.0};
      point.weight = 0.05;
      scan.points.push_back(point);
    }
    return scan;
  };
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  insert_scan(two_walls(-9.0, 0.0, -9.0, 0.0, 3.0), {}, {}, map);
  const PointScan scan = two_walls(-1.0, 2.6, -1.0, 4.0, 2.7);
  const PlacedScans none;
  const MatchProblem problem{scan, {0.6, 0.0, 0.0}, prior_of(2.0, 0.02), map.field, none, 1};
  const MatcherOfTwoMinds matcher(scan.points.size(), {0.3, 0.0, 0.0}, {0.3, -4.0, 0.0});
  EXPECT_EQ(CommonGroundMatch().match(matcher, problem, map).map_from_base.y, 0.0);
}

/// Counts how often it is asked.
class CountedMatcher : public MatcherOfWholeScans {
 public:
  using MatcherOfWholeScans::MatcherOfWholeScans;
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    ++matches;
    return MatcherOfWholeScans::match(problem);
  }
  mutable int matches = 0;
};

/// Of two walls one is mapped from its other side.
class SeenFromBehind : public testing::Test {
 protected:
  SeenFromBehind() { insert_scan(two_walls({5.0, 0.0}, {1.0, 0.0}), {}, {}, map_); }

  static PointScan two_walls(const Eigen::Vector2d& origin, const Eigen::Vector2d& normal) {
    PointScan scan = wall_between(-2.0, 2.0);
    for (double y = -1.0; y <= 1.0; y += 0.05) {
      ScanPoint point{{3.0, y}};
      point.origin = origin;
      point.normal = normal;
      point.weight = 0.05;
      scan.points.push_back(point);
    }
    return scan;
  }

  /// How often a scan is matched that the match has where it was seen.
  int matches_by(const Pose2& odometry, const PointScan& scan) {
    const PlacedScans none;
    const MatchProblem problem{scan, odometry, prior_of(0.3, 0.02), map_.field, none, 1};
    const CountedMatcher matcher(scan.points.size(), {});
    (void)CommonGroundMatch().match(matcher, problem, map_);
    return matcher.matches;
  }

  SlamMap map_{MapOptions{}, LikelihoodFieldOptions{}};
};

TEST_F(SeenFromBehind, IsMatchedOnceWhereOdometryHasTheSamePlace) {
  const PointScan scan = two_walls({0.0, 0.0}, {-1.0, 0.0});
  EXPECT_EQ(matches_by({0.001, 0.0, 0.0}, scan), 1);
  EXPECT_EQ(matches_by({0.01, 0.0, 0.0}, scan), 2);
}

TEST_F(SeenFromBehind, IsMatchedAgainWhereItsSideIsAGuess) {
  EXPECT_EQ(matches_by({0.001, 0.0, 0.0}, two_walls({0.0, 0.0}, {0.0, 0.0})), 2);
}

/// Where a pose has more of a wall on the part that is known, it has more evidence, and yet nothing
/// tells it from one further along.
TEST(EvidenceBetween, GroundThatIsUnknownByOnePoseSaysNothing) {
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  insert_scan(wall_between(-2.0, 0.0), {}, {}, map);
  const PointScan scan = wall_between(-0.6, 1.4);
  const Pose2 drawn{-1.0, 0.0, 0.0};
  const Pose2 further{0.5, 0.0, 0.0};
  EXPECT_GT(evidence_of(scan, drawn, map).log_odds - evidence_of(scan, further, map).log_odds, 5.0);
  EXPECT_EQ(evidence_between(scan, drawn, further, map), 0.0);
  EXPECT_EQ(evidence_between(scan, further, drawn, map), 0.0);
}

TEST(EvidenceBetween, AWallAcrossTheWaySpeaksForThePoseThatHasItThere) {
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  const PointScan scan = wall_between(-2.0, 2.0);
  insert_scan(scan, {}, {}, map);
  const Pose2 before_it{0.0, -0.4, 0.0};
  const double for_truth = evidence_between(scan, {}, before_it, map);
  EXPECT_GT(for_truth, 10.0);
  EXPECT_EQ(evidence_between(scan, before_it, {}, map), -for_truth);
  EXPECT_NEAR(for_truth,
              evidence_of(scan, {}, map).log_odds - evidence_of(scan, before_it, map).log_odds,
              1e-9)
      << "all of it tells";
}

/// A laser of 120 degrees in rooms, which maps what it saw up to half a metre ago: how often a
/// match is off by more than 5 cm where odometry is right.
TEST(CommonGround, IsNotDrawnToWhatIsKnown) {
  SimulationOptions options;
  options.time.duration = 150.0;
  options.laser.beams = 360;
  options.laser.field_of_view = degrees_to_radians(120.0);
  options.laser.range_max = 10.0;
  options.laser.scan_rate = 2.0;
  const World world = make_world("rooms", 21);
  const SimulatedRun run = simulate_run(world, world.route(), options, 21);
  const OlsonMatcher matcher;
  const PlacedScans none;
  CommonGroundMatch common;
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  int by_matcher = 0;
  int by_common_ground = 0;
  for (std::size_t i = 0; i + 2 < run.scans.size(); ++i) {
    const auto seen = [&](std::size_t k) {
      return look_around(world, options.laser, run.world_from_base[k], k);
    };
    insert_scan(seen(i), run.world_from_base[i], {}, map);
    const Pose2& truth = run.world_from_base[i + 2];
    const PointScan scan = seen(i + 2);
    const MatchProblem problem{scan, truth, prior_of(0.2, 0.1), map.field, none, 1};
    const auto is_off = [&](const MatchResult& match) {
      return shift_between(truth, match.map_from_base).head<2>().norm() > 0.05 ? 1 : 0;
    };
    by_matcher += is_off(matcher.match(problem));
    by_common_ground += is_off(common.match(matcher, problem, map));
  }
  EXPECT_EQ(by_matcher, 2) << "of 299, by the thickness of a wall: what it is for";
  EXPECT_EQ(by_common_ground, 0);
}

}  // namespace
}  // namespace matchbox_slam
