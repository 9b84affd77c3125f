#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/refinement.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

TEST(Refine, FindsThePoseFarBelowTheSizeOfACell) {
  std::vector<double> errors_xy;
  std::vector<double> errors_theta;
  Random random(1);
  for (std::uint64_t place = 0; place < 10; ++place) {
    const MatchScene scene = make_match_scene(make_rooms_world(place), LaserOptions{},
                                              6.0 + 3.0 * static_cast<double>(place), place);
    for (int i = 0; i < 5; ++i) {
      const double x = random.uniform(-0.06, 0.06);
      const double y = random.uniform(-0.06, 0.06);
      const Pose2 start = shifted(scene.map_from_base, {x, y, random.uniform(-0.02, 0.02)});
      const RefinedPose refined = refine(scene.scan.points, scene.map.field, start,
                                         {start, prior_of(0.1, 0.05)}, RefinementOptions{});
      const Eigen::Vector3d error = shift_between(scene.map_from_base, refined.map_from_base);
      errors_xy.push_back(error.head<2>().norm());
      errors_theta.push_back(std::abs(error.z()));
    }
  }
  // Measured: 0.47 mm and 0.14 mrad, at worst 1.3 mm and 0.42 mrad; the range noise is 10 mm.
  EXPECT_LT(median(errors_xy), 0.0007);
  EXPECT_LT(median(errors_theta), 0.00021);
  EXPECT_LT(*std::max_element(errors_xy.begin(), errors_xy.end()), 0.002);
  EXPECT_LT(*std::max_element(errors_theta.begin(), errors_theta.end()), 0.00065);
}

TEST(Refine, KeepsThePriorAlongACorridorAndNamesTheDirection) {
  const MatchScene scene = make_match_scene(make_corridor_world(1), LaserOptions{}, 20.0, 1);
  const Pose2 predicted = shifted(scene.map_from_base, {0.07, 0.04, 0.02});
  const Eigen::Matrix3d prior = prior_of(0.1, 0.05);
  const RefinedPose refined = refine(scene.scan.points, scene.map.field, predicted,
                                     {predicted, prior}, RefinementOptions{});
  ASSERT_EQ(refined.unconstrained_directions.size(), 1U);
  EXPECT_NEAR(std::abs(refined.unconstrained_directions[0].x()), 1.0, 1e-3);
  const Eigen::Vector3d error = shift_between(scene.map_from_base, refined.map_from_base);
  EXPECT_NEAR(error.x(), 0.07, 5e-4);
  EXPECT_NEAR(error.y(), 0.0, 0.004);
  EXPECT_NEAR(error.z(), 0.0, 0.001);
  EXPECT_NEAR(refined.covariance(0, 0), 0.01, 1e-4);
  EXPECT_LT(refined.covariance(1, 1), 1e-4);
}

/// What the scan says against the prior's heading tells how far to believe the rest of it.
TEST(Refine, APriorThatProvesWrongIsLessSureAlongACorridor) {
  const MatchScene scene = make_match_scene(make_corridor_world(1), LaserOptions{}, 20.0, 1);
  const Eigen::Matrix3d prior = prior_of(0.1, 0.02);
  const Pose2 predicted = shifted(scene.map_from_base, {0.07, 0.0, 0.1});
  const RefinedPose refined = refine(scene.scan.points, scene.map.field, scene.map_from_base,
                                     {predicted, prior}, RefinementOptions{});
  ASSERT_EQ(refined.unconstrained_directions.size(), 1U);
  EXPECT_LT(std::abs(shift_between(scene.map_from_base, refined.map_from_base).z()), 0.001);
  // Five standard deviations off.
  EXPECT_NEAR(refined.covariance(0, 0), 0.01 / prior_weight_at(25.0), 0.005);
}

/// Far down the corridor beams are too far apart for the wall to be seen as one: single points hold
/// on to single surfaces of a map of few scans, which must not pass for knowledge of the way along.
TEST(Refine, KeepsThePriorAlongACorridorThatWasSeenOnce) {
  const Eigen::Matrix3d prior = prior_of(0.1, 0.05);
  const World corridor = make_corridor_world(2);
  const RobotMotion motion = drive(corridor.route(), {});
  for (std::uint64_t place = 0; place < 20; ++place) {
    const double time = 2.0 + static_cast<double>(place);
    SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
    insert_scan(look_around(corridor, LaserOptions{}, motion.pose(time), 2 * place),
                motion.pose(time), MapOptions{}, map);
    const Pose2 truth = motion.pose(time + 0.5);
    const PointScan scan = look_around(corridor, LaserOptions{}, truth, 2 * place + 1);
    const Pose2 predicted = shifted(truth, {-0.15, 0.0, 0.0});
    const RefinedPose refined =
        refine(scan.points, map.field, predicted, {predicted, prior}, RefinementOptions{});
    EXPECT_EQ(refined.unconstrained_directions.size(), 1U) << place;
    EXPECT_NEAR(shift_between(truth, refined.map_from_base).x(), -0.15, 1e-3) << place;
    EXPECT_GT(refined.covariance(0, 0), 0.0099) << place;
  }
}

TEST(Refine, TheCovarianceFollowsTheNoiseOfTheScan) {
  const auto variance = [](double range_noise) {
    LaserOptions laser;
    laser.range_noise = range_noise;
    const MatchScene scene = make_match_scene(make_rooms_world(1), laser, 10.0, 1);
    return refine(scene.scan.points, scene.map.field, scene.map_from_base,
                  {scene.map_from_base, prior_of(0.1, 0.05)}, RefinementOptions{})
        .covariance.topLeftCorner<2, 2>()
        .trace();
  };
  // Nine times the variance, less what the robust kernel takes for outliers; and the map has an
  // error also where the beams have none.
  EXPECT_GT(variance(0.03), 4.0 * variance(0.01));
  EXPECT_LT(variance(0.03), 12.0 * variance(0.01));
  EXPECT_LT(variance(0.0), 0.3 * variance(0.01));
  EXPECT_GT(variance(0.0), 0.02 * variance(0.01));
}

/// Along walls without noise the map says nothing at all, but for the rounding of its directions,
/// which must not push the pose either.
TEST(Refine, KeepsThePriorAlongPerfectlyStraightWallsInAnyDirection) {
  for (int k = 0; k < 16; ++k) {
    const Pose2 map_from_base{0.3, -0.2, 0.05 + 0.2 * k};
    const Eigen::Rotation2Dd turn(map_from_base.theta);
    LikelihoodField field(0.05, LikelihoodFieldOptions{});
    std::vector<SurfaceHit> hits;
    std::vector<ScanPoint> points;
    for (int i = -150; i <= 150; ++i) {
      for (const double y : {-1.0, 1.0}) {
        const Eigen::Vector2d hit(0.04 * i, y);
        hits.push_back({map_from_base * hit, turn * Eigen::Vector2d(0.0, 1.0)});
        points.push_back({hit, Eigen::Vector2d::Zero(), Eigen::Vector2d(0.0, 1.0), 0.04, true});
      }
    }
    field.update(hits, {});
    const Pose2 predicted = map_from_base * Pose2{0.13, 0.02, 0.01};
    const RefinedPose refined =
        refine(points, field, predicted, {predicted, prior_of(2.0, 0.5)}, RefinementOptions{});
    const Pose2 error = map_from_base.inverse() * refined.map_from_base;
    EXPECT_NEAR(error.x, 0.13, 1e-3) << k;
    EXPECT_NEAR(error.y, 0.0, 1e-3) << k;
    EXPECT_NEAR(error.theta, 0.0, 1e-3) << k;
  }
}

/// A corridor that is not along an axis of the map, 12 m long.
struct Corridor {
  /// @param at_end  of that many points on the wall across its end.
  /// @param noise   of the points [m].
  explicit Corridor(int at_end = 0, double noise = 0.0) {
    Random random(5);
    for (double x = -6.0; x < 6.0; x += 0.02) {
      for (const double side : {-1.0, 1.0}) {
        add({x, side}, {0.0, -side}, {x, side + random.gaussian() * noise});
      }
    }
    for (int i = 0; i < at_end; ++i) {
      add({6.0, 0.05 * i}, {-1.0, 0.0}, {6.0 + random.gaussian() * noise, 0.05 * i});
    }
    field.update(hits, {});
  }

  void add(const Eigen::Vector2d& wall, const Eigen::Vector2d& normal,
           const Eigen::Vector2d& seen) {
    hits.push_back({map_from_corridor * wall, Eigen::Rotation2Dd(0.6) * normal});
    ScanPoint point;
    point.position = seen;
    point.origin = Eigen::Vector2d::Zero();
    point.weight = 0.02;
    points.push_back(point);
  }

  [[nodiscard]] RefinedPose refined() const {
    const Pose2 predicted = map_from_corridor * Pose2{0.05, 0.03, 0.01};
    return refine(points, field, predicted, {predicted, prior_of(0.1, 0.05)}, RefinementOptions{});
  }

  Pose2 map_from_corridor{1.0, 2.0, 0.6};
  LikelihoodField field{0.05, LikelihoodFieldOptions{}};
  std::vector<SurfaceHit> hits;
  std::vector<ScanPoint> points;
};

TEST(Refine, NamesTheDirectionOfASlantingCorridor) {
  const Corridor corridor;
  const RefinedPose refined = corridor.refined();
  ASSERT_EQ(refined.unconstrained_directions.size(), 1U);
  EXPECT_NEAR(std::abs(refined.unconstrained_directions[0].dot(
                  Eigen::Vector2d(std::cos(0.6), std::sin(0.6)))),
              1.0, 1e-6);
  const Pose2 off = corridor.map_from_corridor.inverse() * refined.map_from_base;
  EXPECT_NEAR(off.x, 0.05, 2e-3);
  EXPECT_NEAR(off.y, 0.0, 1e-3);
  EXPECT_NEAR(off.theta, 0.0, 1e-3);
}

TEST(Refine, IsHeldByAFewBeamsOnTheEndOfACorridor) {
  const Corridor corridor(5);  // of 1205
  const RefinedPose refined = corridor.refined();
  EXPECT_TRUE(refined.unconstrained_directions.empty());
  const Pose2 off = corridor.map_from_corridor.inverse() * refined.map_from_base;
  EXPECT_NEAR(off.x, 0.0, 5e-3);
}

TEST(Refine, IsNotHeldByAFewBeamsAmongManyNoisyOnes) {
  EXPECT_EQ(Corridor(5, 0.04).refined().unconstrained_directions.size(), 1U);
}

/// As a depth camera's in a bare corridor: what noise makes of the normals told that it was moved.
TEST(Refine, IsNotHeldByTheNoiseOfNormals) {
  Random random(3);
  const auto noisy = [&random](const Eigen::Vector2d& normal) -> Eigen::Vector2d {
    constexpr double kNoise = 0.15;  // [rad]
    return Eigen::Rotation2Dd(kNoise * random.gaussian()) * normal;
  };
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  std::vector<SurfaceHit> hits;
  std::vector<ScanPoint> points;
  for (int i = 0; i < 120; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d wall(0.05 * i + 0.025, side);
      const Eigen::Vector2d normal(0.0, -side);
      hits.push_back({wall, noisy(normal)});
      points.push_back({wall + Eigen::Vector2d(0.0, 0.01 * random.gaussian()),
                        Eigen::Vector2d::Zero(), noisy(normal), 0.05, true});
    }
  }
  field.update(hits, {});
  const RefinedPose refined = refine(points, field, Pose2{0.1, 0.0, 0.0},
                                     {Pose2{}, prior_of(0.1, 0.05)}, RefinementOptions{});
  EXPECT_EQ(refined.unconstrained_directions.size(), 1U);
  EXPECT_NEAR(refined.map_from_base.x, 0.0, 0.01);
  EXPECT_GT(refined.covariance(0, 0), 0.9 * 0.1 * 0.1) << "the prior's";
}

/// Off the middle of a round room nobody can tell going round from turning: the scan holds the
/// robot on a circle about the room's middle, and the prior decides where on it.
TEST(Refine, StaysOnTheCircleOfARoundRoom) {
  constexpr double kRadius = 3.0;
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  const Pose2 map_from_base{2.0, 0.0, 0.0};
  std::vector<SurfaceHit> hits;
  std::vector<ScanPoint> points;
  for (double angle = -kPi; angle < kPi; angle += 0.005) {
    const Eigen::Vector2d normal(-std::cos(angle), -std::sin(angle));
    hits.push_back({-kRadius * normal, normal});
    ScanPoint point;
    point.position = map_from_base.inverse() * Eigen::Vector2d(-kRadius * normal);
    point.origin = Eigen::Vector2d::Zero();
    point.normal = normal;
    point.weight = 0.015;
    points.push_back(point);
  }
  field.update(hits, {});
  const Pose2 predicted{2.0, 0.15, 0.0};
  const RefinedPose refined =
      refine(points, field, predicted, {predicted, prior_of(0.1, 0.06)}, RefinementOptions{});
  ASSERT_EQ(refined.unconstrained_directions.size(), 1U);
  const Pose2 middle = refined.map_from_base * map_from_base.inverse();
  EXPECT_LT(middle.translation().norm(), 1e-3);
  // Of the 0.15 m, the prior's means split by its variances: 0.01 to (2 m)^2 0.0036.
  EXPECT_NEAR(refined.map_from_base.y, 0.15 * 0.0144 / (0.01 + 0.0144), 2e-3);
  EXPECT_GT(refined.covariance(2, 2), 1e-3);
}

TEST(Refine, WithoutAMapInReachThePriorStands) {
  const MatchScene scene = make_match_scene(make_rooms_world(1), LaserOptions{}, 10.0, 1);
  const Pose2 far{500.0, -500.0, 1.0};
  const Eigen::Matrix3d prior = prior_of(0.1, 0.05);
  const RefinedPose refined =
      refine(scene.scan.points, scene.map.field, far, {far, prior}, RefinementOptions{});
  EXPECT_EQ(refined.score, 0.0);
  EXPECT_EQ(refined.unconstrained_directions.size(), 2U);
  EXPECT_LT(shift_between(far, refined.map_from_base).norm(), 1e-9);
  EXPECT_TRUE(refined.covariance.isApprox(prior, 1e-6));
}

TEST(Refine, APriorOfZeroCovarianceIsKept) {
  const MatchScene scene = make_match_scene(make_rooms_world(1), LaserOptions{}, 10.0, 1);
  const Pose2 predicted = shifted(scene.map_from_base, {0.03, -0.02, 0.01});
  const RefinedPose refined = refine(scene.scan.points, scene.map.field, predicted,
                                     {predicted, Eigen::Matrix3d::Zero()}, RefinementOptions{});
  EXPECT_LT(shift_between(predicted, refined.map_from_base).norm(), 1e-5);
  EXPECT_LT(refined.covariance.norm(), 1e-11);
}

TEST(Refine, NoStepsLeaveTheStart) {
  const MatchScene scene = make_match_scene(make_rooms_world(1), LaserOptions{}, 10.0, 1);
  RefinementOptions options;
  options.iterations = 0;
  const Pose2 start = shifted(scene.map_from_base, {0.03, -0.02, 0.01});
  const RefinedPose refined = refine(scene.scan.points, scene.map.field, start,
                                     {scene.map_from_base, prior_of(0.1, 0.05)}, options);
  EXPECT_EQ(refined.map_from_base, start);
  EXPECT_GT(refined.score, 0.0);
}

TEST(Refine, TheScoreFallsAwayFromTheTruth) {
  const MatchScene scene = make_match_scene(make_rooms_world(1), LaserOptions{}, 10.0, 1);
  RefinementOptions options;
  options.iterations = 0;
  const auto score = [&](double off) {
    const Pose2 pose = shifted(scene.map_from_base, {off, off, 0.0});
    return refine(scene.scan.points, scene.map.field, pose, {pose, prior_of(0.1, 0.05)}, options)
        .score;
  };
  EXPECT_GT(score(0.0), 0.85);
  EXPECT_LE(score(0.0), 1.0);
  EXPECT_GT(score(0.0), score(0.05));
  EXPECT_GT(score(0.05), score(0.1));
}

TEST(LocalPosterior, ItsCurvatureIsTheRefinedCovariance) {
  const MatchScene scene = make_match_scene(make_rooms_world(2), LaserOptions{}, 10.0, 1);
  const PosePrior prior{scene.map_from_base, prior_of(0.1, 0.05)};
  const RefinementOptions options;
  Correspondences pairs(scene.scan.points, scene.map.field, scene.map_from_base);
  const RefinedPose refined = refine(pairs, scene.map_from_base, prior, options);
  const LocalPosterior posterior(pairs, refined.map_from_base, prior, options);
  EXPECT_NEAR(posterior.cost(Eigen::Vector3d::Zero()), 0.0, 1e-12);
  // One standard deviation away along each axis of the covariance costs 1/2, on the mean of both
  // sides; less where the robust kernel forgives outliers.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(refined.covariance);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = std::sqrt(solver.eigenvalues()(i)) * solver.eigenvectors().col(i);
    const double mean = 0.5 * (posterior.cost(step) + posterior.cost(-step));
    EXPECT_GT(mean, 0.35);
    EXPECT_LT(mean, 0.55);
  }
}

TEST(LocalPosterior, TheCostsOfManyStepsAreThoseOfEach) {
  const MatchScene scene = make_match_scene(make_rooms_world(2), LaserOptions{}, 10.0, 1);
  const Correspondences pairs(scene.scan.points, scene.map.field, scene.map_from_base);
  const PosePrior off{shifted(scene.map_from_base, {0.03, -0.02, 0.01}), prior_of(0.02, 0.01)};
  const LocalPosterior posterior(pairs, scene.map_from_base, off, {});
  Random random(3);
  std::vector<Eigen::Vector3d> steps;
  for (int i = 0; i < 50; ++i) {
    const double size = std::pow(10.0, random.uniform(-5.0, 0.0));
    steps.emplace_back(size * random.gaussian(), size * random.gaussian(),
                       size * random.gaussian());
  }
  std::vector<std::array<double, 2>> costs;
  posterior.costs_of_both(steps, costs);
  ASSERT_EQ(costs.size(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (const auto& [cost, step] :
         {std::pair(costs[i][0], steps[i]), std::pair(costs[i][1], Eigen::Vector3d(-steps[i]))}) {
      const double expected = posterior.cost(step);
      EXPECT_NEAR(cost, expected, 5e-5 * std::max(1.0, std::abs(expected))) << step.transpose();
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
