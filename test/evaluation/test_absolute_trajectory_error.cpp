#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "evaluation/moved_trajectory.hpp"

namespace matchbox_slam {
namespace {

constexpr AbsoluteTrajectoryErrorOptions kNoAlignment{Alignment::kNone, 0.5};
constexpr AbsoluteTrajectoryErrorOptions kAligned{Alignment::kSe2, 0.5};

/// A bent path with a pose every 0.1 s.
Trajectory bent_path(int count = 50, double start = 100.0) {
  std::vector<StampedPose2> poses;
  Pose2 pose{2.0, -1.0, 0.4};
  for (int i = 0; i < count; ++i) {
    poses.push_back({start + 0.1 * i, pose});
    pose = pose * Pose2{0.1, 0.0, 0.05 * std::sin(0.2 * i)};
  }
  return Trajectory(poses);
}

/// Every other pose is 0.1 m to one side, the rest to the other.
Trajectory zigzag(const Trajectory& trajectory) {
  std::vector<StampedPose2> poses = trajectory.poses();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].pose = poses[i].pose * Pose2{0.0, i % 2 == 0 ? 0.1 : -0.1, 0.01};
  }
  return Trajectory(poses);
}

TEST(AbsoluteTrajectoryError, IsZeroForTheTruthItself) {
  const auto error = absolute_trajectory_error(bent_path(), bent_path(), kNoAlignment);
  EXPECT_EQ(error.translation.count, 50U);
  EXPECT_EQ(error.translation.max, 0.0);
  EXPECT_EQ(error.heading_rmse, 0.0);
  EXPECT_EQ(error.without_truth, 0U);
}

TEST(AbsoluteTrajectoryError, WithoutAlignmentAgreesWithHandComputation) {
  const Trajectory truth({{0.0, {0, 0, 0}}, {0.5, {1, 0, 0}}, {1.0, {2, 0, 0}}});
  const Trajectory estimate({{0.0, {3, 4, 0.1}}, {0.25, {0.5, 1, -0.1}}, {1.0, {2, 0, 0}}});
  const auto error = absolute_trajectory_error(estimate, truth, kNoAlignment);
  EXPECT_NEAR(error.translation.mean, 2.0, 1e-12);
  EXPECT_NEAR(error.translation.rmse, std::sqrt(26.0 / 3.0), 1e-12);
  EXPECT_NEAR(error.translation.median, 1.0, 1e-12);
  EXPECT_NEAR(error.translation.max, 5.0, 1e-12);
  EXPECT_NEAR(error.heading_rmse, std::sqrt(0.02 / 3.0), 1e-12);
  EXPECT_EQ(error.truth_from_estimate, Pose2{});
}

TEST(AbsoluteTrajectoryError, HeadingErrorIsTakenAlongTheShorterArc) {
  const Trajectory truth({{0.0, {0, 0, 3.1}}, {0.1, {1, 0, 3.1}}});
  const Trajectory estimate({{0.0, {0, 0, -3.1}}, {0.1, {1, 0, -3.1}}});
  EXPECT_NEAR(absolute_trajectory_error(estimate, truth, kNoAlignment).heading_rmse,
              2.0 * kPi - 6.2, 1e-12);
}

/// The square of side 2 around the origin against the same one turned by a quarter and shifted,
/// with its corners in the order in which they match; the alignment is known without computation.
TEST(AlignSe2, FindsAQuarterTurnAndAShift) {
  const std::vector<PosePair> pairs = {{0, {1, 1, 0}, {9, 21, 0}},
                                       {1, {-1, 1, 0}, {9, 19, 0}},
                                       {2, {-1, -1, 0}, {11, 19, 0}},
                                       {3, {1, -1, 0}, {11, 21, 0}}};
  const Pose2 motion = align_se2(pairs);
  EXPECT_NEAR(motion.x, 10.0, 1e-12);
  EXPECT_NEAR(motion.y, 20.0, 1e-12);
  EXPECT_NEAR(motion.theta, 0.5 * kPi, 1e-12);
}

/// Closed form for three collinear points of which the last is off sideways: with the centroids
/// taken out, tan(theta) = sum(cross) / sum(dot) = 1.5 / 2.
TEST(AlignSe2, MinimizesSquaredDistances) {
  const std::vector<PosePair> pairs = {
      {0, {-1, 0, 0}, {-1, 0, 0}}, {1, {0, 0, 0}, {0, 0, 0}}, {2, {1, 0, 0}, {1, 1.5, 0}}};
  const Pose2 motion = align_se2(pairs);
  EXPECT_NEAR(motion.theta, std::atan2(1.5, 2.0), 1e-12);
  EXPECT_NEAR(motion.x, 0.0, 1e-12);
  EXPECT_NEAR(motion.y, 0.5, 1e-12);
}

TEST(AbsoluteTrajectoryError, AlignmentMakesPlaceAndDirectionOfTheEstimateIrrelevant) {
  const Trajectory truth = bent_path();
  const Trajectory estimate = zigzag(truth);
  const auto reference = absolute_trajectory_error(estimate, truth, kAligned);
  EXPECT_NEAR(reference.translation.rmse, 0.1, 0.002);
  EXPECT_NEAR(reference.heading_rmse, 0.01, 0.005);
  for (const Pose2& motion : {Pose2{100, -50, 0}, Pose2{0, 0, 3.0}, Pose2{-7, 3, -2.0}}) {
    const auto error = absolute_trajectory_error(moved(estimate, motion), truth, kAligned);
    EXPECT_NEAR(error.translation.rmse, reference.translation.rmse, 1e-9);
    EXPECT_NEAR(error.translation.max, reference.translation.max, 1e-9);
    EXPECT_NEAR(error.heading_rmse, reference.heading_rmse, 1e-9);
    const Pose2 undone = error.truth_from_estimate * motion;
    EXPECT_NEAR(undone.theta, reference.truth_from_estimate.theta, 1e-9);
  }
}

TEST(AbsoluteTrajectoryError, ReportsWhatTheAlignmentMoved) {
  const Pose2 motion{4.0, -2.0, 1.0};
  const auto error = absolute_trajectory_error(moved(bent_path(), motion), bent_path(), kAligned);
  const Pose2 expected = motion.inverse();
  EXPECT_NEAR(error.truth_from_estimate.x, expected.x, 1e-9);
  EXPECT_NEAR(error.truth_from_estimate.y, expected.y, 1e-9);
  EXPECT_NEAR(error.truth_from_estimate.theta, expected.theta, 1e-9);
}

TEST(AbsoluteTrajectoryError, OrderOfThePosesDoesNotMatter) {
  const Trajectory truth = bent_path();
  std::vector<StampedPose2> poses = zigzag(truth).poses();
  std::reverse(poses.begin(), poses.end());
  std::swap(poses[3], poses[17]);
  const auto sorted = absolute_trajectory_error(zigzag(truth), truth, kAligned);
  const auto shuffled = absolute_trajectory_error(Trajectory(poses), truth, kAligned);
  EXPECT_EQ(sorted.translation.rmse, shuffled.translation.rmse);
}

TEST(AbsoluteTrajectoryError, SwappedEstimateAndTruthAreEquallyFarApart) {
  const Trajectory truth = bent_path();
  const auto there = absolute_trajectory_error(zigzag(truth), truth, kAligned);
  const auto back = absolute_trajectory_error(truth, zigzag(truth), kAligned);
  EXPECT_NEAR(there.translation.rmse, back.translation.rmse, 1e-12);
}

TEST(AbsoluteTrajectoryError, CountsPosesWithoutTruthInAPartialOverlap) {
  const auto error =
      absolute_trajectory_error(bent_path(50, 100.0), bent_path(50, 102.0), kNoAlignment);
  EXPECT_EQ(error.translation.count, 30U);
  EXPECT_EQ(error.without_truth, 20U);
}

TEST(AbsoluteTrajectoryError, OnePoseWithTruthTellsNothing) {
  const Trajectory truth({{0.0, {5, 6, 0.5}}, {1.0, {5, 6, 0.5}}});
  const Trajectory estimate({{1.0, {1, 2, -0.5}}, {9.0, {1, 2, -0.5}}});
  EXPECT_EQ(error_text<EvaluationError>(
                [&] { (void)absolute_trajectory_error(estimate, truth, kAligned); }),
            "only 1 of 2 poses of the estimate has truth, and one alone has no error; the estimate "
            "is from 1.000 to 9.000 s, the truth from 0.000 to 1.000 s; are both in the same "
            "clock?");
}

TEST(AbsoluteTrajectoryError, AnEstimateOfOnePoseHasAnErrorWhereNothingIsAligned) {
  const Trajectory truth({{0.0, {5, 6, 0.5}}, {1.0, {5, 6, 0.5}}});
  const Trajectory estimate(std::vector<StampedPose2>{{1.0, {2, 2, 0.25}}});
  EXPECT_EQ(error_text<EvaluationError>(
                [&] { (void)absolute_trajectory_error(estimate, truth, kAligned); }),
            "the estimate is one pose alone, which has no error when it is aligned with the truth: "
            "at least 2 poses are needed, or alignment none");
  const auto error = absolute_trajectory_error(estimate, truth, kNoAlignment);
  EXPECT_DOUBLE_EQ(error.translation.rmse, 5.0);
  EXPECT_DOUBLE_EQ(error.heading_rmse, 0.25);
}

/// Its positions are noise, and so would be the rotation that fits them best.
TEST(AbsoluteTrajectoryError, ARobotAtRestIsAlignedByItsHeading) {
  for (const double noise : {0.0, 0.01}) {
    std::vector<StampedPose2> truth;
    std::vector<StampedPose2> estimate;
    for (int i = 0; i < 20; ++i) {
      const double angle = 2.0 * i;
      truth.push_back({0.1 * i, {5.0, 6.0, 0.5}});
      estimate.push_back(
          {0.1 * i, {1.0 + noise * std::cos(angle), 2.0 + noise * std::sin(angle), -0.5}});
      truth.back().pose.x += 0.3 * noise * std::sin(1.5 * angle);
    }
    const auto error = absolute_trajectory_error(Trajectory(estimate), Trajectory(truth), kAligned);
    EXPECT_LE(error.translation.max, 1.5 * noise + 1e-12) << noise;
    EXPECT_NEAR(error.heading_rmse, 0.0, 1e-12) << noise;
  }
}

TEST(AbsoluteTrajectoryError, NamesBothTimeRangesWhenStampsNeverMeet) {
  const std::string text = error_text<EvaluationError>([] {
    (void)absolute_trajectory_error(bent_path(11, 100.0), bent_path(11, 200.0), kAligned);
  });
  EXPECT_TRUE(contains(text, "100.000 to 101.000 s")) << text;
  EXPECT_TRUE(contains(text, "200.000 to 201.000 s")) << text;
}

TEST(AbsoluteTrajectoryError, SaysWhichOfTheTwoIsEmpty) {
  EXPECT_EQ(error_text<EvaluationError>([] { (void)absolute_trajectory_error({}, bent_path()); }),
            "the estimate holds no poses");
  EXPECT_EQ(error_text<EvaluationError>([] { (void)absolute_trajectory_error(bent_path(), {}); }),
            "the truth holds no poses");
}

}  // namespace
}  // namespace matchbox_slam
