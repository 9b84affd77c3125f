#include <gtest/gtest.h>

#include <limits>

#include "common/error_text.hpp"
#include "geometry/trajectory.hpp"

namespace matchbox_slam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Trajectory, SortsPosesByStamp) {
  const Trajectory trajectory({{3.0, {3, 0, 0}}, {1.0, {1, 0, 0}}, {2.0, {2, 0, 0}}});
  ASSERT_EQ(trajectory.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(trajectory.poses()[i].stamp, static_cast<double>(i + 1));
    EXPECT_EQ(trajectory.poses()[i].pose.x, static_cast<double>(i + 1));
  }
}

TEST(Trajectory, RefusesNumbersThatAreNotFinite) {
  EXPECT_THROW(Trajectory({StampedPose2{kNaN, {}}}), EvaluationError);
  EXPECT_THROW(Trajectory({StampedPose2{1.0, {0, kNaN, 0}}}), EvaluationError);
  EXPECT_THROW(Trajectory({StampedPose2{1.0, {0, 0, std::numeric_limits<double>::infinity()}}}),
               EvaluationError);
}

TEST(Trajectory, RefusesTwoPosesOfOneStampAndNamesIt) {
  const std::string text = error_text<EvaluationError>([] {
    Trajectory({{1.5, {}}, {2.5, {}}, {1.5, {}}});
  });
  EXPECT_TRUE(contains(text, "two poses have the stamp 1.500000")) << text;
}

TEST(Trajectory, InterpolatesOnTheStraightLineAndTheShorterArc) {
  const Trajectory trajectory({{10.0, {1, 2, 3.0}}, {12.0, {3, 6, -3.0}}});
  const auto pose = trajectory.at(10.5, 5.0);
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->x, 1.5, 1e-12);
  EXPECT_NEAR(pose->y, 3.0, 1e-12);
  EXPECT_NEAR(pose->theta, 3.0 + 0.25 * (2.0 * kPi - 6.0), 1e-12);
}

TEST(Trajectory, HasNoPoseOutsideItsRangeOrAcrossAGap) {
  const Trajectory trajectory({{1.0, {1, 0, 0}}, {2.0, {2, 0, 0}}, {5.0, {5, 0, 0}}});
  EXPECT_FALSE(trajectory.at(0.999, 10.0).has_value());
  EXPECT_FALSE(trajectory.at(5.001, 10.0).has_value());
  EXPECT_FALSE(trajectory.at(3.0, 2.9).has_value());
  EXPECT_TRUE(trajectory.at(3.0, 3.0).has_value());
  EXPECT_FALSE(trajectory.at(kNaN, 10.0).has_value());
  EXPECT_FALSE(Trajectory().at(1.0, 10.0).has_value());
}

TEST(Trajectory, GivesItsOwnPosesWhateverTheGap) {
  const Trajectory trajectory({{1.0, {1, 2, 3}}, {9.0, {4, 5, 0.5}}});
  EXPECT_EQ(trajectory.at(1.0, 0.1), (Pose2{1, 2, 3}));
  EXPECT_EQ(trajectory.at(9.0, 0.1), (Pose2{4, 5, 0.5}));
}

TEST(Trajectory, GivesItsOwnPosesAlsoForStampsThatWereRounded) {
  const Trajectory trajectory({{10.0, {1.0, 0.0, 0.0}}, {11.0, {2.0, 0.0, 0.0}}});
  for (const double rounding : {-1e-6, 1e-6}) {
    ASSERT_TRUE(trajectory.at(10.0 + rounding, 0.5));
    EXPECT_EQ(trajectory.at(10.0 + rounding, 0.5)->x, 1.0);
    ASSERT_TRUE(trajectory.at(11.0 + rounding, 0.5));
    EXPECT_EQ(trajectory.at(11.0 + rounding, 0.5)->x, 2.0);
  }
  EXPECT_FALSE(trajectory.at(10.00001, 0.5));
}

TEST(Associate, InterpolatesTheTruthAndLeavesOutWhatHasNone) {
  const Trajectory truth({{0.0, {0, 0, 0}}, {1.0, {10, 0, 0}}, {3.0, {30, 0, 0}}});
  const Trajectory estimate(
      {{-0.5, {}}, {0.25, {1, 0, 0}}, {1.0, {2, 0, 0}}, {2.0, {3, 0, 0}}, {4.0, {}}});
  const auto pairs = associate(estimate, truth, 1.5);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].stamp, 0.25);
  EXPECT_EQ(pairs[0].estimate.x, 1.0);
  EXPECT_EQ(pairs[0].truth.x, 2.5);
  EXPECT_EQ(pairs[1].estimate.x, 2.0);
  EXPECT_EQ(pairs[1].truth.x, 10.0);
}

}  // namespace
}  // namespace matchbox_slam
