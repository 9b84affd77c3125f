#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {
namespace {

const LikelihoodField& no_map() {
  static const LikelihoodField kEmpty(0.05, {});
  return kEmpty;
}

/// A scan and one key scan, apart by a motion.
struct Pair {
  PointScan scan;
  PlacedScans key_scans;
  Pose2 truth;

  [[nodiscard]] MatchResult match(const Pose2& predicted, const Eigen::Matrix3d& prior,
                                  const HoughOptions& options = {}) const {
    return HoughMatcher(options).match({scan, predicted, prior, no_map(), key_scans, 1});
  }
};

Pair make_pair_of(const World& world, const LaserOptions& laser, const Pose2& first,
                  const Pose2& second, std::uint64_t seed) {
  return {look_around(world, laser, second, seed),
          {placed(look_around(world, laser, first, seed + 1000), first)},
          second};
}

Pair along_route(const World& world, const LaserOptions& laser, double time, std::uint64_t seed) {
  const RobotMotion motion = drive(world.route(), {});
  return make_pair_of(world, laser, motion.pose(time), motion.pose(time + 0.5), seed);
}

Eigen::Vector3d random_error(Random& random) {
  const double x = random.uniform(-0.2, 0.2);
  const double y = random.uniform(-0.2, 0.2);
  return {x, y, random.uniform(-0.2, 0.2)};
}

const Eigen::Matrix3d kPrior = prior_of(0.2 / std::sqrt(3.0), 0.2 / std::sqrt(3.0));

struct ErrorsOverPairs {
  double median_xy;
  double median_theta;
  double mean_nees;
  int found;
};

ErrorsOverPairs over_pairs(const World& world, const LaserOptions& laser, int pairs,
                           const HoughOptions& options = {}) {
  Random random(11);
  std::vector<double> xy;
  std::vector<double> theta;
  ErrorsOverPairs statistics{0.0, 0.0, 0.0, 0};
  for (int i = 0; i < pairs; ++i) {
    const Pair pair =
        along_route(world, laser, random.uniform(2.0, 60.0), static_cast<std::uint64_t>(i));
    const MatchResult result =
        pair.match(shifted(pair.truth, random_error(random)), kPrior, options);
    const Eigen::Vector3d error = shift_between(pair.truth, result.map_from_base);
    xy.push_back(error.head<2>().norm());
    theta.push_back(std::abs(error.z()));
    statistics.found += xy.back() < 0.02 && theta.back() < 0.01 ? 1 : 0;
    statistics.mean_nees += normalised_error_square(result, pair.truth) / pairs;
  }
  std::nth_element(xy.begin(), xy.begin() + pairs / 2, xy.end());
  std::nth_element(theta.begin(), theta.begin() + pairs / 2, theta.end());
  statistics.median_xy = xy[static_cast<std::size_t>(pairs / 2)];
  statistics.median_theta = theta[static_cast<std::size_t>(pairs / 2)];
  return statistics;
}

TEST(Hough, FindsRotationAndTranslationInRooms) {
  const ErrorsOverPairs noisy = over_pairs(make_rooms_world(7), {}, 100);
  EXPECT_LE(noisy.median_xy, 0.0015);
  EXPECT_LE(noisy.median_theta, 0.0002);
  EXPECT_EQ(noisy.found, 100);
  EXPECT_GE(noisy.mean_nees, 2.0);
  EXPECT_LE(noisy.mean_nees, 4.5);
  LaserOptions laser;
  laser.range_noise = 0.0;
  const ErrorsOverPairs clean = over_pairs(make_rooms_world(7), laser, 100);
  EXPECT_LE(clean.median_xy, 0.0002);
  EXPECT_LE(clean.median_theta, 0.00005);
}

TEST(Hough, TheCovarianceHoldsTheCellsWhereNothingRefines) {
  HoughOptions options;
  options.refinement.iterations = 0;
  const double nees = over_pairs(make_rooms_world(7), {}, 50, options).mean_nees;
  EXPECT_GT(nees, 0.5);
  EXPECT_LT(nees, 5.0);
}

TEST(Hough, TellsWhereItsSearchEnded) {
  const MatchScene& scene = rooms_scene();
  const Pose2 predicted = shifted(scene.map_from_base, {0.1, -0.1, 0.1});
  HoughOptions search_only;
  search_only.refinement.iterations = 0;
  const MatchResult raw = HoughMatcher(search_only).match(scene.problem(predicted, kPrior));
  EXPECT_EQ(raw.refined_by, Eigen::Vector3d::Zero());
  const MatchResult refined = HoughMatcher().match(scene.problem(predicted, kPrior));
  EXPECT_GT(refined.refined_by.norm(), 0.0005);
  EXPECT_LT(difference(refined.searched_map_from_base(), raw.map_from_base).norm(), 1e-12);
}

TEST(Hough, FindsItsWayThroughClutter) {
  EXPECT_GE(over_pairs(make_random_world(4), {}, 100).found, 95);
}

TEST(Hough, KeepsThePriorAlongACorridor) {
  const World world = make_corridor_world(6);  // along the x axis
  Random random(3);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Pair pair = along_route(world, {}, 10.0 + static_cast<double>(i), i);
    const Eigen::Vector3d off = random_error(random);
    const MatchResult result = pair.match(shifted(pair.truth, off), kPrior);
    ASSERT_TRUE(result.accepted());
    const Eigen::Vector3d error = shift_between(pair.truth, result.map_from_base);
    EXPECT_LE(std::abs(error.z()), 0.001);
    EXPECT_LE(std::abs(error.y()), 0.005);
    EXPECT_NEAR(error.x(), off.x(), 0.002);
    EXPECT_EQ(result.unconstrained_directions.size(), 1U);
    EXPECT_NEAR(result.covariance(0, 0), kPrior(0, 0), 0.05 * kPrior(0, 0));
  }
}

TEST(Hough, SearchesKeyScansAndRefinesOnTheMap) {
  MatchScene scene = rooms_scene();
  const Pose2 predicted = shifted(scene.map_from_base, {0.1, -0.1, 0.1});
  const auto match = [&] { return HoughMatcher().match(scene.problem(predicted, kPrior)); };
  const Pose2 on_map = match().map_from_base;
  EXPECT_LE(shift_between(scene.map_from_base, on_map).norm(), 0.001);
  // Key scans that lie a little beside the map lead to the same place.
  for (PlacedScan& key : scene.key_scans) {
    key.map_from_base = shifted(key.map_from_base, {0.03, 0.02, 0.0});
  }
  EXPECT_LE(shift_between(on_map, match().map_from_base).norm(), 0.0005);
  scene.map = SlamMap(MapOptions{}, LikelihoodFieldOptions{});
  EXPECT_GE(shift_between(on_map, match().map_from_base).norm(), 0.03);
  scene.key_scans.clear();
  EXPECT_EQ(match().status, MatchStatus::kRejectedNoReference);
}

TEST(Hough, SwappingTheScansInvertsTheAnswer) {
  const World world = make_rooms_world(7);
  Random random(5);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const double time = random.uniform(2.0, 60.0);
    const Pair pair = along_route(world, {}, time, i);
    const PlacedScan& key = pair.key_scans.front();
    const Pair swapped{*key.scan->points(), {placed(pair.scan, pair.truth)}, key.map_from_base};
    const MatchResult forth = pair.match(shifted(pair.truth, random_error(random)), kPrior);
    const MatchResult inverse = swapped.match(shifted(swapped.truth, random_error(random)), kPrior);
    ASSERT_TRUE(forth.accepted() && inverse.accepted());
    const Pose2 there = key.map_from_base.inverse() * forth.map_from_base;
    const Pose2 back = pair.truth.inverse() * inverse.map_from_base;
    const Pose2 round = there * back;
    EXPECT_LE(round.translation().norm(), 0.004) << i;
    EXPECT_LE(std::abs(round.theta), 0.001) << i;
  }
}

TEST(Hough, SearchesTheWholeCircleWithoutAPrior) {
  const MatchScene& scene = rooms_scene();
  for (const double turn : {-3.0, -1.5, 0.7, 1.6, 2.4}) {
    const Pose2 predicted = shifted(scene.map_from_base, {0.3, -0.4, turn});
    const MatchResult result = HoughMatcher().match(scene.problem(predicted, prior_of(1.0, 1e3)));
    ASSERT_TRUE(result.accepted());
    const Eigen::Vector3d error = shift_between(scene.map_from_base, result.map_from_base);
    EXPECT_LE(error.head<2>().norm(), 0.005) << turn;
    EXPECT_LE(std::abs(error.z()), 0.001) << turn;
  }
}

TEST(Hough, AsksFurtherKeyScansWhenTheNearestSaysTooLittle) {
  MatchScene scene = rooms_scene();
  // At the very place, but it saw only a bit of wall.
  PointScan little = scene.scan;
  little.points.resize(6);
  scene.key_scans.push_back(placed(little, scene.map_from_base));
  const Pose2 predicted = shifted(scene.map_from_base, {0.5, -0.5, 0.5});
  const auto error = [&](const HoughOptions& options) {
    const MatchProblem problem = scene.problem(predicted, prior_of(0.5, 0.5));
    const Pose2 found = HoughMatcher(options).match(problem).map_from_base;
    return shift_between(scene.map_from_base, found).norm();
  };
  HoughOptions one;
  one.searched_key_scans = 1;
  EXPECT_GE(error(one), 0.1);
  EXPECT_LE(error({}), 0.005);
}

/// A bare rectangle of a room, that looks the same after half a turn.
PointScan rectangle() {
  PointScan scan;
  const auto add = [&](double x, double y, const Eigen::Vector2d& normal) {
    scan.points.push_back({{x, y}, {0.0, 0.0}, normal, 0.05, false});
  };
  for (int i = 0; i < 120; ++i) {
    add(3.0, -2.0 + i / 30.0, {-1.0, 0.0});
  }
  for (int i = 0; i < 180; ++i) {
    add(3.0 - i / 30.0, 2.0, {0.0, -1.0});
  }
  for (int i = 0; i < 120; ++i) {
    add(-3.0, 2.0 - i / 30.0, {1.0, 0.0});
  }
  for (int i = 0; i < 180; ++i) {
    add(-3.0 + i / 30.0, -2.0, {0.0, 1.0});
  }
  return scan;
}

TEST(Hough, ThePriorDecidesBetweenPosesThatFitAlike) {
  const Pair room{rectangle(), {placed(rectangle(), Pose2{})}, {}};
  for (const double heading : {0.3, kPi - 0.3}) {
    const MatchResult result = room.match({0.05, 0.05, heading}, prior_of(0.3, 1.0));
    ASSERT_TRUE(result.accepted());
    EXPECT_NEAR(std::abs(wrap_angle(result.map_from_base.theta)), heading < 1.0 ? 0.0 : kPi, 0.01);
    EXPECT_GT(result.rival_share, 0.6);
  }
}

TEST(Hough, CanBeAskedAnythingWithoutHarm) {
  const MatchScene& scene = rooms_scene();
  const Pose2 predicted = shifted(scene.map_from_base, {0.1, -0.1, 0.1});
  const Eigen::Vector3d line(1.0, 0.5, 0.3);
  for (const Eigen::Matrix3d& prior :
       {Eigen::Matrix3d(100.0 * line * line.transpose()), Eigen::Matrix3d(prior_of(1e100, 1e100)),
        Eigen::Matrix3d(Eigen::Matrix3d::Zero())}) {
    const MatchResult result = HoughMatcher().match(scene.problem(predicted, prior));
    EXPECT_TRUE(result.covariance.allFinite());
    EXPECT_TRUE(std::isfinite(result.score));
  }
  const MatchResult wide = HoughMatcher().match(scene.problem(predicted, prior_of(1e100, 1e100)));
  EXPECT_LE(shift_between(scene.map_from_base, wide.map_from_base).norm(), 0.01);
  MatchScene heavy = scene;
  for (ScanPoint& point : heavy.scan.points) {
    point.weight = 1e308;
  }
  EXPECT_FALSE(HoughMatcher().match(heavy.problem(predicted, kPrior)).accepted());
}

TEST(Hough, TellsOfARival) {
  const MatchScene& scene = rooms_scene();
  const MatchResult wide =
      HoughMatcher().match(scene.problem(scene.map_from_base, prior_of(1.0, 1e3)));
  EXPECT_GT(wide.candidates, 5U);
  EXPECT_LT(wide.rival_share, 0.9);
}

}  // namespace
}  // namespace matchbox_slam
