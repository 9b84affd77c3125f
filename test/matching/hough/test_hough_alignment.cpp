#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/hough/hough_alignment.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

/// Two scans of one world and the motion between them.
struct TwoScans {
  HoughPoints reference;
  HoughPoints scan;
  Pose2 reference_from_scan;
};

TwoScans two_scans(const World& world, const Pose2& first, const Pose2& motion) {
  const HoughAlignmentOptions options;
  return {hough_points(look_around(world, {}, first, 1).points, options.point_spacing),
          hough_points(look_around(world, {}, first * motion, 2).points, options.point_spacing),
          motion};
}

TwoScans in_rooms(const Pose2& motion) {
  return two_scans(make_rooms_world(7), rooms_scene().map_from_base, motion);
}

HoughAlignment best_of(const std::vector<HoughAlignment>& alignments) {
  return *std::max_element(
      alignments.begin(), alignments.end(),
      [](const HoughAlignment& a, const HoughAlignment& b) { return a.vote < b.vote; });
}

double eigenvalue_ratio(const HoughAlignment& alignment) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(alignment.information);
  return solver.eigenvalues()(0) / solver.eigenvalues()(1);
}

TEST(AlignInHoughDomain, FindsRotationAndTranslation) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const double x = random.uniform(-0.2, 0.2);
    const double y = random.uniform(-0.2, 0.2);
    const Pose2 motion{x, y, random.uniform(-0.2, 0.2)};
    const TwoScans scans = in_rooms(motion);
    const std::vector<HoughAlignment> found =
        align_in_hough_domain(scans.reference, scans.scan, {{}, prior_of(0.12, 0.12)}, {});
    ASSERT_FALSE(found.empty());
    const Eigen::Vector3d error = shift_between(motion, best_of(found).reference_from_scan);
    EXPECT_LT(error.head<2>().norm(), 0.03) << i;
    EXPECT_LT(std::abs(error.z()), 0.005) << i;
    EXPECT_GT(eigenvalue_ratio(best_of(found)), 0.1) << "a room holds both directions";
  }
}

TEST(AlignInHoughDomain, NeedsNoGuess) {
  for (const double turn : {-2.5, -1.0, 0.5, 1.5}) {
    const TwoScans scans = in_rooms({0.3, -0.2, turn});
    const std::vector<HoughAlignment> found =
        align_in_hough_domain(scans.reference, scans.scan, {{}, prior_of(1.0, 1e3)}, {});
    const bool is_there = std::any_of(found.begin(), found.end(), [&](const HoughAlignment& one) {
      const Eigen::Vector3d error =
          shift_between(scans.reference_from_scan, one.reference_from_scan);
      return error.head<2>().norm() < 0.05 && std::abs(error.z()) < 0.01;
    });
    EXPECT_TRUE(is_there) << turn;
  }
}

TEST(AlignInHoughDomain, KeepsTheGuessAlongASingleWall) {
  HoughPoints wall;
  for (int i = -100; i <= 100; ++i) {
    wall.x.push_back(2.0F);
    wall.y.push_back(0.05F * static_cast<float>(i));
    wall.weight.push_back(0.05F);
  }
  wall.reach = 5.4;
  HoughPoints scan = wall;  // 0.1 m nearer to the wall, and an unknown way along it
  for (float& x : scan.x) {
    x -= 0.1F;
  }
  const std::vector<HoughAlignment> found =
      align_in_hough_domain(wall, scan, {{0.0, 0.07, 0.0}, prior_of(0.1, 0.02)}, {});
  ASSERT_FALSE(found.empty());
  const HoughAlignment best = best_of(found);
  EXPECT_NEAR(best.reference_from_scan.x, 0.1, 0.005);
  EXPECT_NEAR(best.reference_from_scan.y, 0.07, 1e-9);
  EXPECT_NEAR(best.reference_from_scan.theta, 0.0, 1e-3);
  EXPECT_LT(eigenvalue_ratio(best), 0.01);
}

TEST(AlignInHoughDomain, SaysNothingOfNothing) {
  const TwoScans scans = in_rooms({});
  EXPECT_TRUE(align_in_hough_domain({}, scans.scan, {{}, prior_of(0.1, 0.1)}, {}).empty());
  EXPECT_TRUE(align_in_hough_domain(scans.reference, {}, {{}, prior_of(0.1, 0.1)}, {}).empty());
}

std::vector<float> bumps(const std::vector<std::pair<double, double>>& at_and_height) {
  std::vector<float> correlation(180, 0.0F);
  for (int k = 0; k < 180; ++k) {
    double value = 0.0;
    for (const auto& [at, height] : at_and_height) {
      const double away = std::remainder(k - at, 180.0);
      value += height * std::exp(-0.5 * away * away / 4.0);
    }
    correlation[static_cast<std::size_t>(k)] = static_cast<float>(value);
  }
  return correlation;
}

TEST(FindRotations, InterpolatesBetweenColumns) {
  const std::vector<RotationPeak> found = find_rotations(bumps({{10.3, 1.0}}), 0.1, 0.2, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].angle, degrees_to_radians(10.3), degrees_to_radians(0.03));
}

TEST(FindRotations, KeepsBothHalvesOfTheCircleWithoutAPrior) {
  const std::vector<RotationPeak> found = find_rotations(bumps({{30.0, 1.0}}), 0.0, 1e3, {});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(std::abs(wrap_angle(found[0].angle - found[1].angle)), kPi, 1e-9);
}

TEST(FindRotations, LetsThePriorDecide) {
  const std::vector<float> two = bumps({{5.0, 0.95}, {25.0, 1.0}});
  EXPECT_NEAR(find_rotations(two, 0.0, 1e3, {}).front().correlation, 1.0, 0.01);
  EXPECT_NEAR(find_rotations(two, degrees_to_radians(4.0), 0.13, {}).front().angle,
              degrees_to_radians(5.0), 0.005);
  EXPECT_EQ(find_rotations(two, degrees_to_radians(5.0), 0.05, {}).size(), 1U)
      << "the other one lies outside the window";
}

TEST(FindRotations, StaysAtTheGuessWhereThereIsNoPeak) {
  const std::vector<RotationPeak> found =
      find_rotations(std::vector<float>(180, 0.0F), 0.4, 0.1, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].angle, 0.4);
}

}  // namespace
}  // namespace matchbox_slam
