#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/error_text.hpp"
#include "evaluation/moved_trajectory.hpp"
#include "evaluation/relative_pose_error.hpp"

namespace matchbox_slam {
namespace {

using Unit = PairRule::Unit;

RelativePoseErrorOptions only(Unit unit, double step = 1.0) {
  RelativePoseErrorOptions options;
  options.rules = {{unit, step}};
  return options;
}

RelativePoseErrorMeasure measured(const Trajectory& estimate, const Trajectory& truth, Unit unit,
                                  double step = 1.0) {
  return relative_pose_error(estimate, truth, only(unit, step)).measures.at(0);
}

/// A pose every 0.25 s, 0.4 m/s, through curves.
Trajectory winding_path(int count = 200, double start = 100.0) {
  std::vector<StampedPose2> poses;
  Pose2 pose{2.0, -1.0, 0.4};
  for (int i = 0; i < count; ++i) {
    poses.push_back({start + 0.25 * i, pose});
    pose = pose * Pose2{0.1, 0.0, 0.1 * std::sin(0.2 * i)};
  }
  return Trajectory(poses);
}

/// Each step is longer than the true one by 1 % and turns 0.01 rad more.
Trajectory drifting(const Trajectory& truth) {
  std::vector<StampedPose2> poses = truth.poses();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose2 step = truth.poses()[i - 1].pose.inverse() * truth.poses()[i].pose;
    poses[i].pose = poses[i - 1].pose * Pose2{1.01 * step.x, 1.01 * step.y, step.theta + 0.01};
  }
  return Trajectory(poses);
}

TEST(RelativePoseError, PerScanAgreesWithHandComputation) {
  const Trajectory truth({{0.0, {0, 0, 0}}, {0.4, {1, 0, 0}}, {0.8, {2, 0, 0}}});
  // The first step 0.3 m too long and 0.4 m to the left; the second, seen from a heading of 0.1,
  // as long as it should be but for the turn back.
  const Trajectory estimate({{0.0, {0, 0, 0}},
                             {0.4, {1.3, 0.4, 0.1}},
                             {0.8, {1.3 + std::cos(0.1), 0.4 + std::sin(0.1), 0.0}}});
  const auto measure = measured(estimate, truth, Unit::kScan);
  ASSERT_EQ(measure.differences.size(), 2U);
  EXPECT_EQ(measure.differences[1].stamp, 0.4);
  EXPECT_NEAR(measure.differences[0].translation, 0.5, 1e-12);
  EXPECT_NEAR(measure.differences[1].translation, 0.0, 1e-12);
  EXPECT_NEAR(measure.differences[0].rotation, 0.1, 1e-12);
  EXPECT_NEAR(measure.differences[1].rotation, 0.1, 1e-12);
  EXPECT_NEAR(measure.translation->rmse, std::sqrt(0.125), 1e-12);
  EXPECT_NEAR(measure.translation->mean, 0.25, 1e-12);
  EXPECT_NEAR(measure.rotation->max, 0.1, 1e-12);
}

TEST(RelativePoseError, DirectionOfTheDifferenceIsThatOfTheDefinition) {
  // Truth turns by a quarter and stays; the estimate turns, then goes 1 m: the translation of
  // (T_i^-1 T_j)^-1 (P_i^-1 P_j) is the same whichever way it is turned, but the rotation counts.
  const Trajectory truth({{0.0, {0, 0, 0}}, {0.4, {1, 0, 0.5 * kPi}}});
  const Trajectory estimate({{0.0, {0, 0, 0}}, {0.4, {1, 2, -0.5 * kPi - 0.1}}});
  const auto measure = measured(estimate, truth, Unit::kScan);
  EXPECT_NEAR(measure.translation->max, 2.0, 1e-12);
  EXPECT_NEAR(measure.rotation->max, kPi - 0.1, 1e-12);
}

TEST(RelativePoseError, PerScanDoesNotPairAcrossAPoseWithoutTruth) {
  const Trajectory truth({{0.0, {}}, {0.4, {}}, {3.0, {}}, {3.4, {}}});
  const Trajectory estimate({{0.0, {}}, {0.4, {}}, {2.0, {}}, {3.0, {}}, {3.4, {}}});
  const auto error = relative_pose_error(estimate, truth, only(Unit::kScan));
  EXPECT_EQ(error.without_truth, 1U);
  ASSERT_EQ(error.measures[0].differences.size(), 2U);
  EXPECT_EQ(error.measures[0].differences[1].stamp, 3.0);
}

TEST(RelativePoseError, PerSecondTakesTheNearestPoseWithinTenPercent) {
  const Trajectory truth({{0.0, {}}, {0.5, {}}, {1.0, {}}, {1.5, {}}, {2.0, {}}, {2.5, {}}});
  // From 0: 0.95 rather than 1.06. From 0.95: 2.05 is too late and 1.84 too early.
  const Trajectory estimate({{0.0, {0, 0, 0}},
                             {0.95, {1, 0, 0}},
                             {1.06, {7, 0, 0}},
                             {1.84, {7, 0, 0}},
                             {2.06, {10, 0, 0}}});
  const auto measure = measured(estimate, truth, Unit::kSecond);
  ASSERT_EQ(measure.differences.size(), 2U);
  EXPECT_EQ(measure.differences[0].stamp, 0.0);
  EXPECT_NEAR(measure.differences[0].translation, 1.0, 1e-12);
  EXPECT_EQ(measure.differences[1].stamp, 1.06);
  EXPECT_NEAR(measure.differences[1].translation, 3.0, 1e-12);
}

TEST(RelativePoseError, PerMetreFollowsThePathOfTheTruth) {
  // Out for 3 m and back; the path is longer than the displacement.
  std::vector<StampedPose2> poses;
  for (int i = 0; i <= 24; ++i) {
    const double path = 0.25 * i;
    poses.push_back({0.4 * i, {path <= 3.0 ? path : 6.0 - path, 0.0, 0.0}});
  }
  const Trajectory truth(poses);
  for (StampedPose2& stamped : poses) {
    stamped.pose.x *= 1.1;
  }
  const auto measure = measured(Trajectory(poses), truth, Unit::kMetre, 5.0);
  // From 0 to 5 m along the path, at 1 m; from 1 m to 6 m of it, at 0; within 10 % also others.
  ASSERT_EQ(measure.differences.size(), 7U);
  EXPECT_NEAR(measure.differences[0].translation, 0.1, 1e-12);
  EXPECT_NEAR(measure.differences[2].translation, 0.0, 1e-12);
  EXPECT_NEAR(measure.differences[4].translation, 0.1, 1e-12);
  EXPECT_NEAR(measured(Trajectory(poses), truth, Unit::kMetre, 1.0).translation->max, 0.1, 1e-12);
}

TEST(RelativePoseError, PerMetreTakesTheFirstPoseWhereTheRobotRested) {
  for (const double rest : {0.95, 1.0, 1.05}) {
    const Trajectory truth({{0.0, {0, 0, 0}},
                            {0.4, {rest, 0, 0}},
                            {0.8, {rest, 0, 0}},
                            {1.2, {rest, 0, 0}},
                            {1.6, {5, 0, 0}}});
    const Trajectory estimate({{0.0, {0, 0, 0}},
                               {0.4, {rest + 0.5, 0, 0}},
                               {0.8, {4, 0, 0}},
                               {1.2, {8, 0, 0}},
                               {1.6, {9, 0, 0}}});
    const auto measure = measured(estimate, truth, Unit::kMetre);
    ASSERT_EQ(measure.differences.size(), 1U);
    EXPECT_NEAR(measure.differences[0].translation, 0.5, 1e-12) << rest;
  }
}

TEST(RelativePoseError, PerMetreDoesNotSpanAGapOfTheTruth) {
  const Trajectory truth({{0.0, {0, 0, 0}}, {0.4, {0.5, 0, 0}}, {5.0, {1.0, 0, 0}}});
  EXPECT_THROW((void)measured(truth, truth, Unit::kMetre), EvaluationError);
  RelativePoseErrorOptions patient = only(Unit::kMetre);
  patient.max_gap = 5.0;
  EXPECT_EQ(relative_pose_error(truth, truth, patient).measures[0].differences.size(), 1U);
}

TEST(RelativePoseError, PerMetreFindsThePartnerBeforeAGapThoughOneBeyondItIsNearer) {
  const Trajectory truth(
      {{0.0, {0, 0, 0}}, {0.4, {0.93, 0, 0}}, {5.0, {1.0, 0, 0}}, {5.4, {1.5, 0, 0}}});
  const auto measure = measured(truth, truth, Unit::kMetre);
  ASSERT_EQ(measure.differences.size(), 1U);
  EXPECT_EQ(measure.differences[0].stamp, 0.0);
  EXPECT_NEAR(measure.translation->max, 0.0, 1e-12);
}

TEST(RelativePoseError, AMeasureWithoutPairsIsEmptyAndNoError) {
  const auto error = relative_pose_error(winding_path(30), winding_path(30));
  ASSERT_EQ(error.measures.size(), 6U);
  for (const RelativePoseErrorMeasure& measure : error.measures) {
    const bool is_beyond = measure.rule.unit == Unit::kMetre && measure.rule.step > 2.0;
    EXPECT_EQ(measure.translation.has_value(), !is_beyond);
    EXPECT_EQ(measure.rotation.has_value(), !is_beyond);
    EXPECT_EQ(measure.differences.empty(), is_beyond);
  }
}

TEST(RelativePoseError, GrowsWithTheStep) {
  const Trajectory truth = winding_path();
  const auto error = relative_pose_error(drifting(truth), truth);
  EXPECT_NEAR(error.measures[0].rotation->max, 0.01, 1e-9);
  // Not the means: the last pairs are up to 10 % shorter.
  EXPECT_NEAR(error.measures[1].rotation->median, 0.04, 1e-9);
  EXPECT_NEAR(error.measures[2].rotation->median, 0.10, 1e-9);
  EXPECT_NEAR(error.measures[3].rotation->median, 0.50, 1e-9);
  EXPECT_NEAR(error.measures[4].rotation->median, 1.00, 1e-9);
  EXPECT_NEAR(error.measures[0].translation->mean, 0.001, 1e-9);
}

TEST(RelativePoseError, PerRadianFollowsTheTurningOfTheTruth) {
  // Half a circle to the left and back to the right, in steps of 0.25 rad, on the spot.
  std::vector<StampedPose2> poses;
  for (int i = 0; i <= 24; ++i) {
    const double turning = 0.25 * i;
    poses.push_back({0.4 * i, {1.0, 2.0, turning <= 3.0 ? turning : 6.0 - turning}});
  }
  const Trajectory truth(poses);
  for (StampedPose2& stamped : poses) {
    stamped.pose.theta = wrap_angle(1.1 * stamped.pose.theta);
  }
  const auto measure = measured(Trajectory(poses), truth, Unit::kRadian, 2.0);
  ASSERT_EQ(measure.differences.size(), 17U);
  EXPECT_NEAR(measure.differences[0].rotation, 0.2, 1e-12);
  EXPECT_NEAR(measure.differences[8].rotation, 0.0, 1e-12) << "as far back as out";
  EXPECT_NEAR(measure.differences[12].rotation, 0.2, 1e-12) << "to the right alike";
  EXPECT_NEAR(measure.translation->max, 0.0, 1e-12);
}

TEST(RelativePoseError, PerRadianDoesNotSpanAGapOfTheTruth) {
  const Trajectory truth({{0.0, {0, 0, 0}}, {0.4, {0, 0, 0.5}}, {5.0, {0, 0, 1.0}}});
  EXPECT_THROW((void)measured(truth, truth, Unit::kRadian), EvaluationError);
}

TEST(RelativePoseError, ARigidMotionOfEitherChangesNothing) {
  const Trajectory truth = winding_path();
  const Trajectory estimate = drifting(truth);
  const auto reference = relative_pose_error(estimate, truth);
  for (const Pose2& motion : {Pose2{100, -50, 0}, Pose2{0, 0, 3.0}, Pose2{-7, 3, -2.0}}) {
    for (const auto& error : {relative_pose_error(moved(estimate, motion), truth),
                              relative_pose_error(estimate, moved(truth, motion))}) {
      for (std::size_t i = 0; i < 6; ++i) {
        const auto& expected = reference.measures[i];
        EXPECT_EQ(error.measures[i].differences.size(), expected.differences.size());
        EXPECT_NEAR(error.measures[i].translation->rmse, expected.translation->rmse, 1e-9);
        EXPECT_NEAR(error.measures[i].rotation->rmse, expected.rotation->rmse, 1e-9);
      }
    }
  }
}

TEST(RelativePoseError, SwappedEstimateAndTruthAreEquallyFarApartPerScan) {
  const Trajectory truth = winding_path();
  const auto there = measured(drifting(truth), truth, Unit::kScan);
  const auto back = measured(truth, drifting(truth), Unit::kScan);
  EXPECT_NEAR(there.translation->rmse, back.translation->rmse, 1e-12);
  EXPECT_NEAR(there.rotation->rmse, back.rotation->rmse, 1e-12);
}

TEST(RelativePoseError, OrderOfThePosesDoesNotMatter) {
  const Trajectory truth = winding_path();
  std::vector<StampedPose2> poses = drifting(truth).poses();
  std::reverse(poses.begin(), poses.end());
  std::swap(poses[3], poses[17]);
  EXPECT_EQ(measured(Trajectory(poses), truth, Unit::kMetre).translation->rmse,
            measured(drifting(truth), truth, Unit::kMetre).translation->rmse);
}

TEST(RelativePoseError, UsesThePartOfTheEstimateThatHasTruth) {
  const auto error = relative_pose_error(winding_path(50, 100.0), winding_path(50, 105.0));
  EXPECT_EQ(error.without_truth, 20U);
  EXPECT_EQ(error.measures[0].differences.size(), 29U);
}

TEST(RelativePoseError, SaysWhatIsMissing) {
  EXPECT_EQ(error_text<EvaluationError>([] { (void)relative_pose_error({}, winding_path()); }),
            "the estimate holds no poses");
  EXPECT_EQ(error_text<EvaluationError>([] { (void)relative_pose_error(winding_path(), {}); }),
            "the truth holds no poses");
  const std::string never_meet = error_text<EvaluationError>(
      [] { (void)relative_pose_error(winding_path(5, 100.0), winding_path(5, 200.0)); });
  EXPECT_TRUE(contains(never_meet, "100.000 to 101.000 s")) << never_meet;
  EXPECT_TRUE(contains(never_meet, "200.000 to 201.000 s")) << never_meet;
  EXPECT_EQ(error_text<EvaluationError>(
                [] { (void)relative_pose_error(winding_path(1), winding_path(9)); }),
            "no two poses of the estimate make a pair: 1 of 1 poses have truth");
  EXPECT_THROW((void)measured(winding_path(), winding_path(), Unit::kMetre, 0.0),
               std::invalid_argument);
}

}  // namespace
}  // namespace matchbox_slam
