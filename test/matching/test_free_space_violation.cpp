#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "matchbox_slam/matching/free_space_violation.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {
namespace {

/// A field with one wall along y at x = 0, hit every 2 cm from y = -3 to 3 m.
LikelihoodField wall() {
  LikelihoodField field(0.05, {});
  std::vector<SurfaceHit> hits;
  for (int i = -150; i <= 150; ++i) {
    hits.push_back({{0.0, 0.02 * i}, {-1.0, 0.0}});
  }
  field.update(hits, {});
  return field;
}

/// A scan of one beam of weight 1.
PointScan beam(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  PointScan scan;
  ScanPoint point;
  point.origin = from;
  point.position = to;
  point.weight = 1.0;
  scan.points = {point};
  return scan;
}

TEST(FreeSpaceViolation, ABeamThroughAWallContradictsTheMap) {
  const LikelihoodField field = wall();
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.3}, {2.0, 0.5}), {}, field), 1.0);
  EXPECT_EQ(free_space_violation(beam({2.0, 0.3}, {-2.0, 1.5}), {}, field), 1.0);
  // Where it is counts by the pose.
  EXPECT_EQ(free_space_violation(beam({0.0, 0.0}, {4.0, 0.0}), {0.0, -2.0, 0.5 * kPi}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({0.0, 0.0}, {4.0, 0.0}), {-2.0, 0.0, 0.3}, field), 1.0);
}

TEST(FreeSpaceViolation, ABeamThatEndsAtOrALittleBehindAWallDoesNot) {
  const LikelihoodField field = wall();
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.0}, {0.0, 0.0}), {}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.0}, {0.35, 0.0}), {}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.0}, {0.55, 0.0}), {}, field), 1.0);
}

TEST(FreeSpaceViolation, ABeamAlongAWallOrPastItDoesNot) {
  const LikelihoodField field = wall();
  EXPECT_EQ(free_space_violation(beam({0.02, -2.0}, {0.02, 2.0}), {}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({-0.2, -2.5}, {0.3, 2.5}), {}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({-2.0, 3.2}, {2.0, 3.2}), {}, field), 0.0);
}

TEST(FreeSpaceViolation, PointsCountByTheirWeight) {
  PointScan scan = beam({-2.0, 0.0}, {2.0, 0.0});
  scan.points.push_back(beam({-2.0, 0.0}, {-1.0, 0.0}).points.front());
  scan.points.back().weight = 3.0;
  EXPECT_DOUBLE_EQ(free_space_violation(scan, {}, wall()), 0.25);
}

TEST(FreeSpaceViolation, WhatIsNoBeamCountsForNothing) {
  const LikelihoodField field = wall();
  EXPECT_EQ(free_space_violation(PointScan{}, {}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.0}, {2.0, 0.0}), {}, LikelihoodField(0.05, {})),
            0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.0}, {nan, 0.0}), {}, field), 0.0);
  EXPECT_EQ(free_space_violation(beam({-2.0, 0.0}, {-1e12, 0.0}), {}, field), 0.0);
}

TEST(FreeSpaceViolation, TellsWrongPlacesFromTheRightOne) {
  // In a map of one place: at the true pose nearly nothing; turned or in the next room much.
  const World world = make_rooms_world(4);
  const RobotMotion motion = drive(world.route(), DriveOptions{});
  double most_at_truth = 0.0;
  double sum_elsewhere = 0.0;
  int scenes = 0;
  for (double time = 20.0; time < 200.0; time += 9.0) {
    const MatchScene scene = make_match_scene(world, LaserOptions{}, time, 3);
    most_at_truth = std::max(
        most_at_truth, free_space_violation(scene.scan, scene.map_from_base, scene.map.field));
    for (const double turn : {1.0, -2.0}) {
      sum_elsewhere += free_space_violation(
          scene.scan, shifted(scene.map_from_base, {0.6, -0.4, turn}), scene.map.field);
      ++scenes;
    }
  }
  EXPECT_LT(most_at_truth, 0.005);
  EXPECT_GT(sum_elsewhere / scenes, 0.25);
}

PointScan beam_from_right() {
  PointScan scan = beam({1.0, 0.0}, {0.0, 0.1});
  scan.points.front().normal = {1.0, 0.0};
  return scan;
}

TEST(ShareOnOtherSides, IsOfPointsThatFaceAwayFromWhereAWallWasSeen) {
  LikelihoodField field = wall();  // seen from the left
  const auto share = [&](double x, double normal_x) {
    PointScan scan = beam({x + normal_x, 0.0}, {x, 0.1});
    scan.points.front().normal = {normal_x, 0.0};
    scan.points.push_back(beam({-3.0, 0.0}, {-2.0, 0.0}).points.front());  // on no wall
    scan.points.back().weight = 3.0;
    return share_on_other_sides(scan, {}, field);
  };
  EXPECT_EQ(share(0.0, -1.0), 0.0);
  EXPECT_EQ(share(0.0, 1.0), 0.25);
  EXPECT_EQ(share(0.04, 1.0), 0.25) << "about there";
  EXPECT_EQ(share(0.16, 1.0), 0.0) << "where the other side may be";
  EXPECT_EQ(share(0.0, 0.0), 0.0) << "a hit of unknown normal";
  EXPECT_EQ(share_on_other_sides(beam_from_right(), {}, field), 1.0);
  std::vector<SurfaceHit> hits;
  for (int i = -150; i <= 150; ++i) {
    hits.push_back({{0.0, 0.02 * i}, {1.0, 0.0}});
  }
  field.update(hits, {});  // seen from both sides: as thin as a cell
  EXPECT_EQ(share_on_other_sides(beam_from_right(), {}, field), 0.0);
  EXPECT_EQ(share_on_other_sides(PointScan{}, {}, field), 0.0);
}

}  // namespace
}  // namespace matchbox_slam
