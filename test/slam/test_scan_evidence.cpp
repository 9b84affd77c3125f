#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

constexpr double kWall = 2.0;    // [m] ahead
constexpr double kBehind = 4.0;  // [m]
constexpr int kBeams = 100;

/// Where a fan of beams ahead meets a wall across, if `is_hit` of its number, or else one behind.
template <typename IsHit>
PointScan fan(IsHit&& is_hit, int beams = kBeams, double weight = 0.05) {
  PointScan scan;
  for (int i = 0; i < beams; ++i) {
    const double slope = -0.5 + (i + 0.5) / beams;
    const double x = is_hit(i) ? kWall : kBehind;
    ScanPoint point;
    point.position = {x, x * slope};
    point.normal = {-1.0, 0.0};
    point.weight = weight;
    scan.points.push_back(point);
  }
  return scan;
}

PointScan wall() {
  return fan([](int /*beam*/) { return true; });
}
PointScan behind() {
  return fan([](int /*beam*/) { return false; });
}

/// Half of its beams pass, never the same.
PointScan railing(std::uint64_t seed) {
  Random random(seed);
  return fan([&](int /*beam*/) { return random.uniform() < 0.5; });
}

SlamMap empty_map() { return {MapOptions{}, LikelihoodFieldOptions{}}; }

SlamMap map_of_wall() {
  SlamMap map = empty_map();
  for (int i = 0; i < 20; ++i) {
    insert_scan(wall(), {}, {}, map);
  }
  return map;
}

SlamMap map_of_railing() {
  SlamMap map = empty_map();
  for (int i = 0; i < 20; ++i) {
    insert_scan(railing(static_cast<std::uint64_t>(i)), {}, {}, map);
  }
  return map;
}

MatchScene look_at_rooms(std::uint64_t seed = 3) {
  LaserOptions laser;
  laser.beams = 520;
  return make_match_scene(make_rooms_world(seed), laser, 12.0, seed);
}

void expect_nothing(const ScanEvidence& evidence) {
  EXPECT_EQ(evidence.log_odds, 0.0);
  EXPECT_EQ(evidence.mean, 0.0);
  EXPECT_EQ(evidence.known, 0.0);
  EXPECT_EQ(evidence.telling, 0.0);
  EXPECT_EQ(evidence.telling_witnesses, 0.0);
  EXPECT_EQ(evidence.telling_mean, 0.0);
}

TEST(ScanEvidence, SpeaksForTheTruePoseAndLessForPosesThatAreOff) {
  for (const std::uint64_t seed : {3U, 4U, 5U}) {
    const MatchScene scene = look_at_rooms(seed);
    const ScanEvidence there = evidence_of(scene.scan, scene.map_from_base, scene.map);
    EXPECT_GT(there.mean, 2.0) << seed;
    EXPECT_GT(there.log_odds, 50.0) << seed;
    EXPECT_GT(there.known, 0.85) << seed;
    for (int i = 0; i < 8; ++i) {
      const double angle = 0.25 * kPi * i;
      const Pose2 beside =
          shifted(scene.map_from_base, {0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.0});
      EXPECT_LT(evidence_of(scene.scan, beside, scene.map).log_odds, there.log_odds - 30.0)
          << seed << " " << i;
    }
    for (const double turn : {-0.3, 0.3}) {
      const Pose2 turned = shifted(scene.map_from_base, {0.0, 0.0, turn});
      EXPECT_LT(evidence_of(scene.scan, turned, scene.map).log_odds, there.log_odds - 30.0)
          << seed << " " << turn;
    }
  }
}

TEST(ScanEvidence, HardlyMindsAnErrorOfHalfACell) {
  const MatchScene scene = look_at_rooms();
  const double there = evidence_of(scene.scan, scene.map_from_base, scene.map).mean;
  for (const double x : {-0.025, 0.025}) {
    for (const double y : {-0.025, 0.025}) {
      const Pose2 near = shifted(scene.map_from_base, {x, y, 0.0});
      EXPECT_NEAR(evidence_of(scene.scan, near, scene.map).mean, there, 0.2);
    }
  }
}

TEST(ScanEvidence, SaysNothingOnUnknownGround) {
  const MatchScene scene = look_at_rooms();
  expect_nothing(evidence_of(scene.scan, {500.0, 0.0, 0.3}, scene.map));
  expect_nothing(evidence_of(scene.scan, scene.map_from_base, empty_map()));
}

TEST(ScanEvidence, SaysNothingWithoutPoints) {
  const MatchScene scene = look_at_rooms();
  PointScan scan;
  expect_nothing(evidence_of(scan, scene.map_from_base, scene.map));
  scan.free_rays = {{{0.0, 0.0}, {5.0, 0.0}}};
  expect_nothing(evidence_of(scan, scene.map_from_base, scene.map));
}

TEST(ScanEvidence, SpeaksAgainstBeamsThroughASolidWall) {
  const SlamMap map = map_of_wall();
  const ScanEvidence evidence = evidence_of(behind(), {}, map);
  EXPECT_LT(evidence.mean, -2.6);
  EXPECT_LT(evidence.log_odds, -20.0);
  EXPECT_EQ(evidence.known, 0.0) << "they end behind it";
  EXPECT_GT(evidence_of(wall(), {}, map).mean, 2.9);
}

TEST(ScanEvidence, TellsOfWallsByWhatEndsOnThemOrGoesThrough) {
  const SlamMap map = map_of_wall();
  const ScanEvidence on_wall = evidence_of(wall(), {}, map);
  EXPECT_GT(on_wall.telling, 0.95);
  EXPECT_NEAR(on_wall.telling_witnesses, 4.0, 0.1) << "half metres";
  EXPECT_GT(on_wall.telling_mean, 2.9);
  const ScanEvidence through = evidence_of(behind(), {}, map);
  EXPECT_GT(through.telling, 0.95);
  EXPECT_NEAR(through.telling_witnesses, 8.0, 0.2);
  EXPECT_LT(through.telling_mean, -2.6);
}

TEST(ScanEvidence, WhatStandsInTheWayTellsNothingOfWalls) {
  const auto before_wall = [](int beam) { return beam < 70; };
  PointScan blocked = wall();
  for (int i = 0; i < kBeams; ++i) {
    if (before_wall(i)) {
      blocked.points[static_cast<std::size_t>(i)].position *= 0.5;
    }
  }
  const ScanEvidence evidence = evidence_of(blocked, {}, map_of_wall());
  EXPECT_LT(evidence.mean, 0.0) << "most beams end on free ground";
  EXPECT_NEAR(evidence.telling, 0.3, 0.03);
  EXPECT_LT(evidence.telling_witnesses, 2.0) << "0.6 m of wall, and what lies beside its edge";
  EXPECT_GT(evidence.telling_mean, 2.9);
}

TEST(ScanEvidence, BeamsThroughGlassThatEndOnAWallDoNotSpeakAgainstAPose) {
  PointScan from_between = behind();  // as in a room that is seen from both sides of a pane
  for (ScanPoint& point : from_between.points) {
    point.origin = 0.75 * point.position;
  }
  const Pose2 aslant{0.0, 0.0, 0.25 * kPi};  // so that the pane is several cells thick
  SlamMap map = empty_map();
  for (int i = 0; i < 20; ++i) {
    insert_scan(wall(), aslant, {}, map);
    insert_scan(from_between, aslant, {}, map);
  }
  const ScanEvidence evidence = evidence_of(behind(), aslant, map);
  EXPECT_GT(evidence.known, 0.95);
  EXPECT_GT(evidence.mean, 0.8);
}

TEST(ScanEvidence, TakesARailingForBothWallAndWay) {
  const SlamMap map = map_of_railing();
  EXPECT_GT(evidence_of(behind(), {}, map).mean, 1.0);
  EXPECT_GT(evidence_of(wall(), {}, map).mean, 1.0);
  EXPECT_GT(evidence_of(railing(99), {}, map).mean, 1.0);
}

TEST(ScanEvidence, SpeaksAgainstBeamsThatEndWhereOthersWentOn) {
  const SlamMap map = map_of_wall();
  const ScanEvidence evidence = evidence_of(wall(), {-0.5, 0.0, 0.0}, map);
  EXPECT_NEAR(evidence.known, 0.75, 0.02) << "the map is of a fan, too";
  EXPECT_LT(evidence.mean, -2.0 * evidence.known);
}

TEST(ScanEvidence, OfABeamIsLimited) {
  const MatchScene scene = look_at_rooms();
  Random random(17);
  double least = 0.0;
  double most = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double size = i % 2 == 0 ? 0.1 : 6.0;
    const Pose2 pose = shifted(
        scene.map_from_base,
        {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)});
    const ScanEvidence evidence = evidence_of(scene.scan, pose, scene.map);
    ASSERT_GE(evidence.mean, -3.0);
    ASSERT_LE(evidence.mean, 3.0);
    ASSERT_GE(evidence.known, 0.0);
    ASSERT_LE(evidence.known, 1.0 + 1e-12);
    if (std::abs(evidence.mean) > 0.3) {  // the one by weights, the other by length of wall
      ASSERT_EQ(evidence.mean > 0.0, evidence.log_odds > 0.0);
    }
    least = std::min(least, evidence.mean);
    most = std::max(most, evidence.mean);
  }
  EXPECT_LT(least, -1.0);
  EXPECT_GT(most, 2.0);
}

TEST(ScanEvidence, HasAWitnessEachHalfMetreOfWall) {
  const ScanEvidence evidence = evidence_of(wall(), {}, map_of_wall());
  const double length = kWall * (kBeams - 1) / kBeams;  // from its first hit to its last
  EXPECT_NEAR(evidence.log_odds, evidence.mean * length / 0.5, 1e-9);
}

TEST(ScanEvidence, HasAWitnessEachBeamThatIsFarFromTheNext) {
  const SlamMap map = map_of_wall();
  const ScanEvidence evidence = evidence_of(fan([](int /*beam*/) { return true; }, 4), {}, map);
  EXPECT_NEAR(evidence.log_odds, evidence.mean * (4 - 1), 1e-9) << "0.5 m apart";
  const ScanEvidence of_two = evidence_of(fan([](int /*beam*/) { return true; }, 2), {}, map);
  EXPECT_NEAR(of_two.log_odds, of_two.mean, 1e-9) << "1 m apart";
}

/// What is between them may be anything.
TEST(ScanEvidence, CountsOfSparsePointsWithoutNormalWhatTheyHit) {
  const SlamMap map = map_of_wall();
  PointScan scan = fan([](int /*beam*/) { return true; }, 4);
  for (ScanPoint& point : scan.points) {
    point.normal.setZero();
    point.spacing = 0.5;
  }
  const ScanEvidence evidence = evidence_of(scan, {}, map);
  EXPECT_NEAR(evidence.log_odds, 0.1 * evidence.mean * (4 - 1), 1e-9) << "0.05 of 0.5 m";
  EXPECT_NEAR(evidence.telling_witnesses, 0.1 * (4 - 1), 1e-9);
  EXPECT_GT(evidence.mean, 1.0);
}

/// Its other side lies behind it, as far as it is thick, and nothing is known of that.
TEST(ScanEvidence, SaysNothingOfTheOtherSideOfAWall) {
  const SlamMap map = map_of_wall();
  const Pose2 from_behind{2.0 * kWall, 0.0, kPi};
  const ScanEvidence evidence = evidence_of(wall(), from_behind, map);
  EXPECT_NEAR(evidence.mean, 0.0, 0.05);
  EXPECT_LT(evidence.known, 0.05);
  EXPECT_LT(evidence.telling, 0.05);
  PointScan without_normals = wall();
  for (ScanPoint& point : without_normals.points) {
    point.normal.setZero();
  }
  EXPECT_GT(evidence_of(without_normals, from_behind, map).mean, 2.0) << "they show no side";
}

TEST(ScanEvidence, OfAWallDoesNotDependOnHowManyBeamsItIsSeenBy) {
  const SlamMap map = map_of_wall();
  const auto seen_by = [&](int beams) {
    const PointScan scan = fan([](int beam) { return beam % 7 != 0; }, beams, 2.0 / beams);
    return evidence_of(scan, {}, map).log_odds;
  };
  const double expected = seen_by(140);
  EXPECT_GT(expected, 5.0);
  EXPECT_NEAR(seen_by(700), expected, 0.1 * expected);
  EXPECT_NEAR(seen_by(1400), expected, 0.1 * expected);
}

TEST(ScanEvidence, CountsBeamsByTheirWeights) {
  const SlamMap map = map_of_wall();
  PointScan scan = fan([](int beam) { return beam % 2 == 0; });
  for (std::size_t i = 1; i < scan.points.size(); i += 2) {
    scan.points[i].weight = 0.0;
  }
  const ScanEvidence hits = evidence_of(scan, {}, map);
  EXPECT_NEAR(hits.log_odds, evidence_of(wall(), {}, map).log_odds, 0.5) << "the same wall";
  EXPECT_EQ(hits.known, 1.0);
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    scan.points[i].weight = i % 2 == 0 ? 0.01 : 0.03;
  }
  EXPECT_NEAR(evidence_of(scan, {}, map).known, 0.25, 1e-9);
}

TEST(ScanEvidence, TellsWhichShareEndsOnKnownGround) {
  const PointScan scan = fan([](int beam) { return beam < 25; });
  EXPECT_NEAR(evidence_of(scan, {}, map_of_wall()).known, 0.25, 1e-9);
}

TEST(ScanEvidence, IgnoresWildReadings) {
  const SlamMap map = map_of_wall();
  PointScan scan = wall();
  const ScanEvidence expected = evidence_of(scan, {}, map);
  for (const double range : {101.0, 1e9, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    scan.points.push_back(scan.points.back());
    scan.points.back().position = {range, 0.0};
  }
  const ScanEvidence evidence = evidence_of(scan, {}, map);
  EXPECT_NEAR(evidence.mean, expected.mean, 1e-9);
  EXPECT_NEAR(evidence.log_odds, expected.log_odds, 1e-9);
  EXPECT_EQ(evidence.known, expected.known);
}

TEST(ScanEvidence, OfABeamWithoutLengthIsANumber) {
  PointScan scan = wall();
  scan.points.front().position.setZero();
  EXPECT_TRUE(std::isfinite(evidence_of(scan, {}, map_of_wall()).log_odds));
}

TEST(ScanEvidence, IsTheSameWhereverTheMapLies) {
  const MatchScene scene = look_at_rooms();
  MapOptions options;
  options.resolution = 0.0625;  // of which whole numbers have no rounding
  const Eigen::Vector3d by(-77 * options.resolution, 1234 * options.resolution, 0.0);
  SlamMap map(options, {});
  SlamMap moved(options, {});
  for (const PlacedScan& key : scene.key_scans) {
    insert_scan(*key.scan->points(), key.map_from_base, options, map);
    insert_scan(*key.scan->points(), shifted(key.map_from_base, by), options, moved);
  }
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Pose2 pose =
        shifted(scene.map_from_base,
                {random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.2, 0.2)});
    const ScanEvidence here = evidence_of(scene.scan, pose, map);
    const ScanEvidence there = evidence_of(scene.scan, shifted(pose, by), moved);
    EXPECT_NEAR(here.log_odds, there.log_odds, 1e-6) << i;
    EXPECT_NEAR(here.mean, there.mean, 1e-6) << i;
    EXPECT_NEAR(here.known, there.known, 1e-6) << i;
  }
}

TEST(ScanEvidence, TheSameQuestionHasTheSameAnswer) {
  const MatchScene scene = look_at_rooms();
  const SlamMap copy = scene.map;
  const Pose2 pose = shifted(scene.map_from_base, {0.1, 0.0, 0.05});
  const ScanEvidence a = evidence_of(scene.scan, pose, scene.map);
  const ScanEvidence b = evidence_of(scene.scan, pose, copy);
  EXPECT_EQ(a.log_odds, b.log_odds);
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.known, b.known);
}

TEST(ScanEvidence, SpeaksForElsewhereWhereItContradicts) {
  const MatchScene scene = look_at_rooms();
  const ScanEvidence right = evidence_of(scene.scan, scene.map_from_base, scene.map);
  EXPECT_EQ(odds_of_elsewhere(right), -1.0);
  EXPECT_FALSE(is_badly_explained(right));
  const Pose2 wrong_pose = shifted(scene.map_from_base, {1.3, 0.9, 0.7});
  const ScanEvidence wrong = evidence_of(scene.scan, wrong_pose, scene.map);
  EXPECT_EQ(odds_of_elsewhere(wrong), 9.0);
  EXPECT_TRUE(is_badly_explained(wrong));
  const Pose2 unknown_pose = shifted(scene.map_from_base, {500.0, 0.0, 0.0});
  const ScanEvidence unknown = evidence_of(scene.scan, unknown_pose, scene.map);
  EXPECT_EQ(odds_of_elsewhere(unknown), 0.0) << "nothing is known there";
  EXPECT_FALSE(is_badly_explained(unknown));
}

TEST(ScanEvidence, SpeaksOfElsewhereAsFarAsItTellsOfWalls) {
  ScanEvidence evidence;
  const auto with = [&evidence](double witnesses, double mean) {
    evidence.telling_witnesses = witnesses;
    evidence.telling_mean = mean;
    return odds_of_elsewhere(evidence);
  };
  EXPECT_DOUBLE_EQ(with(0.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(with(1.0, -3.0), 2.25) << "a few beams through walls, as of a carried robot";
  EXPECT_DOUBLE_EQ(with(2.0, 3.0), -0.5);
  EXPECT_DOUBLE_EQ(with(2.0, 1.5), 0.125) << "a door that was drawn a little off";
  EXPECT_DOUBLE_EQ(with(4.0, 0.0), 4.0);
  EXPECT_DOUBLE_EQ(with(4.0, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(with(4.0, 2.0), -1.0);
  EXPECT_DOUBLE_EQ(with(4.0, -3.0), 9.0) << "one scan is not enough";
  EXPECT_DOUBLE_EQ(with(40.0, -3.0), 9.0) << "from two metres on it counts whole";
}

/// A wall close by fills all of a narrow scan, and is one wall all the same.
TEST(ScanEvidence, TellsOfMetresOfWallAndNotOfBeams) {
  const SlamMap map = map_of_wall();
  for (const int beams : {50, 100, 170}) {
    PointScan one_metre = fan([](int /*beam*/) { return true; }, beams, 5.0 / beams);
    const auto is_far = [](const ScanPoint& point) { return std::abs(point.position.y()) > 0.5; };
    std::vector<ScanPoint>& points = one_metre.points;
    points.erase(std::remove_if(points.begin(), points.end(), is_far), points.end());
    const ScanEvidence part = evidence_of(one_metre, {}, map);
    EXPECT_GT(part.telling, 0.95);
    EXPECT_NEAR(part.telling_witnesses, 2.0, 0.1) << "half metres, of " << beams << " beams";
  }
}

/// As many beams end on the near wall as go through it, and these see twice as much behind it.
TEST(ScanEvidence, HasTheMeanOfWhatItTellsByLengthOfWall) {
  const PointScan half = fan([](int beam) { return beam < 50; });
  const ScanEvidence evidence = evidence_of(half, {}, map_of_wall());
  EXPECT_GT(evidence.mean, -0.2);
  EXPECT_LT(evidence.telling_mean, -0.5);
}

}  // namespace
}  // namespace matchbox_slam
