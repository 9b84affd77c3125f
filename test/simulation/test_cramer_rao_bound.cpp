#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>

#include "simulation/cramer_rao_bound.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kNoise = 0.01;

/// A beam that met a wall.
BeamTruth beam_to(const Eigen::Vector2d& end, const Eigen::Vector2d& normal, double cos_incidence) {
  BeamTruth beam;
  beam.range = end.norm();
  beam.segment = 0;
  beam.normal = normal;
  beam.cos_incidence = cos_incidence;
  beam.end = end;
  return beam;
}

/// What a laser measures of these beams, whatever its angles.
LaserScan scan_of(const std::vector<BeamTruth>& beams) {
  LaserScan scan;
  scan.range_max = 100.0;
  for (const BeamTruth& beam : beams) {
    scan.ranges.push_back(static_cast<float>(beam.range));
  }
  return scan;
}

Eigen::Matrix3d information_of(const std::vector<BeamTruth>& beams, const Pose2& world_from_base) {
  return fisher_information(beams, scan_of(beams), world_from_base, kNoise);
}

std::vector<BeamTruth> beams_at(const World& world, const LaserOptions& laser, const Pose2& pose) {
  return trace_beams(
      world, laser, [&](double /*stamp*/) { return pose; }, 0.0);
}

TEST(FisherInformation, OfABeamStraightAtAWallIsAboutItsDistance) {
  const Eigen::Matrix3d information = information_of({beam_to({3.0, 0.0}, {-1.0, 0.0}, 1.0)}, {});
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected(0, 0) = 1.0 / (kNoise * kNoise);
  EXPECT_LT((information - expected).norm(), 1e-9);
}

TEST(FisherInformation, OfAGrazingBeamIsGreater) {
  // At 60 degrees of incidence the range changes by 2 m for each metre towards the wall. The wall
  // is the line y = 1, met at x = sqrt(3); turning by dt moves the end by sqrt(3) dt towards it.
  const double x = std::sqrt(3.0);
  const Eigen::Matrix3d information = information_of({beam_to({x, 1.0}, {0.0, -1.0}, 0.5)}, {});
  EXPECT_NEAR(information(1, 1) * kNoise * kNoise, 4.0, 1e-9);
  EXPECT_NEAR(information(2, 2) * kNoise * kNoise, 4.0 * 3.0, 1e-9);
  EXPECT_NEAR(information(0, 0), 0.0, 1e-9);
}

TEST(FisherInformation, OfBeamsThatMeetNothingIsNone) {
  EXPECT_EQ(information_of({BeamTruth{}, BeamTruth{}}, {}), Eigen::Matrix3d::Zero());
}

TEST(FisherInformation, OfReadingsThatWereLostIsNone) {
  const std::vector<BeamTruth> beams(3, beam_to({3.0, 0.0}, {-1.0, 0.0}, 1.0));
  LaserScan scan = scan_of(beams);
  scan.range_min = 0.1;
  scan.ranges = {3.0F, std::numeric_limits<float>::quiet_NaN(), 100.0F};
  EXPECT_NEAR(fisher_information(beams, scan, {}, kNoise)(0, 0) * kNoise * kNoise, 1.0, 1e-9);
  scan.ranges = {0.05F, std::numeric_limits<float>::infinity()};
  EXPECT_EQ(fisher_information(beams, scan, {}, kNoise), Eigen::Matrix3d::Zero());
}

TEST(FisherInformation, LeavesTheWayAlongACorridorOpen) {
  const World world = make_world("corridor", 1);
  const Pose2 pose{world.route().waypoints.front().x(), world.route().waypoints.front().y(), 0.0};
  const Eigen::Matrix3d information = information_of(beams_at(world, {}, pose), pose);
  EXPECT_LT(information(0, 0), 1e-9 * information(1, 1));
}

/// The same from the ranges themselves, by small motions of the base along its own axes.
Eigen::Matrix3d information_by_differences(const World& world, const LaserOptions& laser,
                                           const Pose2& pose) {
  constexpr double kStep = 1e-7;
  const std::vector<BeamTruth> at_pose = beams_at(world, laser, pose);
  const std::array<Pose2, 3> steps = {Pose2{kStep, 0.0, 0.0}, Pose2{0.0, kStep, 0.0},
                                      Pose2{0.0, 0.0, kStep}};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  std::array<std::vector<BeamTruth>, 3> moved;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    moved[i] = beams_at(world, laser, pose * steps[i]);
  }
  for (std::size_t k = 0; k < at_pose.size(); ++k) {
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    bool is_on_one_wall = at_pose[k].segment.has_value();
    for (std::size_t i = 0; i < steps.size(); ++i) {
      is_on_one_wall = is_on_one_wall && moved[i][k].segment == at_pose[k].segment;
      gradient(static_cast<Eigen::Index>(i)) = (moved[i][k].range - at_pose[k].range) / kStep;
    }
    if (is_on_one_wall) {
      sum += gradient * gradient.transpose();
    }
  }
  return sum / (kNoise * kNoise);
}

class FisherInformationInAWorld : public testing::TestWithParam<const char*> {};

TEST_P(FisherInformationInAWorld, IsWhatDifferencesOfTheRangesTell) {
  const World world = make_world(GetParam(), 3);
  LaserOptions laser;
  laser.beams = 400;
  laser.mount_y = 0.1;
  laser.mount_yaw = 0.4;
  laser.mount_pitch = 0.2;
  const Eigen::Vector2d start = world.route().waypoints.front();
  const Pose2 pose{start.x(), start.y(), 1.1};
  const Eigen::Matrix3d analytic = information_of(beams_at(world, laser, pose), pose);
  const Eigen::Matrix3d numeric = information_by_differences(world, laser, pose);
  EXPECT_LT((analytic - numeric).norm(), 1e-4 * numeric.norm()) << analytic << "\n\n" << numeric;
}

INSTANTIATE_TEST_SUITE_P(Worlds, FisherInformationInAWorld, testing::Values("rooms", "random"));

// --- two scans ---

/// Beams whose walls a robot meets at a pose in a world of clutter.
std::vector<BeamTruth> in_clutter(const Pose2& pose) {
  return beams_at(make_world("random", 3), {}, pose);
}

TEST(FisherInformationOfPair, OfScansFromOnePlaceIsHalfOfOnes) {
  const Pose2 pose{0.3, -0.2, 0.7};
  const std::vector<BeamTruth> beams = in_clutter(pose);
  const Eigen::Matrix3d one = information_of(beams, pose);
  const Eigen::Matrix3d both =
      fisher_information_of_pair(beams, scan_of(beams), beams, scan_of(beams), pose, kNoise);
  EXPECT_LT((both - 0.5 * one).norm(), 1e-6 * one.norm());
}

TEST(FisherInformationOfPair, OfAReferenceWithoutNoiseIsThatOfAKnownWorld) {
  const Pose2 pose{0.3, -0.2, 0.7};
  const std::vector<BeamTruth> beams = in_clutter(pose);
  // As many equal beams as make a reference a million times as exact.
  std::vector<BeamTruth> exact;
  for (BeamTruth beam : beams) {
    beam.cos_incidence *= 1e-3;
    exact.push_back(beam);
  }
  const Eigen::Matrix3d one = information_of(beams, pose);
  const Eigen::Matrix3d both =
      fisher_information_of_pair(exact, scan_of(exact), beams, scan_of(beams), pose, kNoise);
  EXPECT_LT((both - one).norm(), 1e-4 * one.norm());
}

TEST(FisherInformationOfPair, OfScansFromTwoPlacesIsLessInEveryDirection) {
  const Pose2 pose{0.3, -0.2, 0.7};
  const std::vector<BeamTruth> reference = in_clutter({0.0, 0.0, 0.5});
  const std::vector<BeamTruth> beams = in_clutter(pose);
  const Eigen::Matrix3d half = 0.5 * information_of(beams, pose);
  const Eigen::Matrix3d both = fisher_information_of_pair(reference, scan_of(reference), beams,
                                                          scan_of(beams), pose, kNoise);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information_of(beams, pose) - both);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
  EXPECT_GT(both.trace(), 0.1 * half.trace());
}

TEST(FisherInformationOfPair, OfAWallThatOneScanMeetsIsNone) {
  const std::vector<BeamTruth> one = {beam_to({3.0, 0.0}, {-1.0, 0.0}, 1.0)};
  std::vector<BeamTruth> other = one;
  other[0].segment = 1;
  EXPECT_EQ(fisher_information_of_pair(one, scan_of(one), other, scan_of(other), {}, kNoise),
            Eigen::Matrix3d::Zero());
  // Its other side is another surface.
  other = {beam_to({3.0, 0.0}, {1.0, 0.0}, 1.0)};
  EXPECT_EQ(fisher_information_of_pair(one, scan_of(one), other, scan_of(other), {}, kNoise),
            Eigen::Matrix3d::Zero());
}

TEST(FisherInformationOfPair, OfOneBeamEachIsAboutTheDistance) {
  const std::vector<BeamTruth> beams = {beam_to({3.0, 0.0}, {-1.0, 0.0}, 1.0)};
  const Eigen::Matrix3d information =
      fisher_information_of_pair(beams, scan_of(beams), beams, scan_of(beams), {}, kNoise);
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected(0, 0) = 0.5 / (kNoise * kNoise);
  EXPECT_LT((information - expected).norm(), 1e-6);
}

}  // namespace
}  // namespace matchbox_slam
