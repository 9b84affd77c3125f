#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/error_text.hpp"
#include "evaluation/relation_error.hpp"
#include "io/real_data.hpp"
#include "io/relations_file.hpp"
#include "io/tum.hpp"

namespace matchbox_slam {
namespace {

/// Along x, one metre and one second a pose.
Trajectory straight_drive(int poses) {
  std::vector<StampedPose2> drive;
  for (int i = 0; i < poses; ++i) {
    drive.push_back({1.0 * i, {1.0 * i, 0.0, 0.0}});
  }
  return Trajectory(drive);
}

TEST(RelationError, AgreesWithHandComputation) {
  // Against the drive's (1, 0, 0) and (2, 0, 0) of two and of one pose back.
  const std::vector<Relation> relations = {
      {0.0, 1.0, {1.0, 3.0, 0.0}}, {2.0, 4.0, {2.0, 0.0, 0.2}}, {3.0, 2.0, {-2.0, 0.0, -0.4}}};
  const RelationError error = relation_error(straight_drive(6), relations);
  ASSERT_EQ(error.differences.size(), 3U);
  EXPECT_EQ(error.unusable, 0U);
  EXPECT_NEAR(error.differences[0].translation, 3.0, 1e-12);
  EXPECT_NEAR(error.differences[1].translation, 0.0, 1e-12);
  EXPECT_NEAR(error.differences[2].translation, 1.0, 1e-12);
  EXPECT_NEAR(error.translation.mean, 4.0 / 3.0, 1e-12);
  EXPECT_NEAR(error.translation.deviation, std::sqrt(14.0) / 3.0, 1e-12);
  EXPECT_NEAR(error.translation.max, 3.0, 1e-12);
  EXPECT_NEAR(error.translation_squared.mean, 10.0 / 3.0, 1e-12);
  EXPECT_NEAR(error.translation_squared.deviation, std::sqrt((81.0 + 1.0) / 3.0 - 100.0 / 9.0),
              1e-12);
  EXPECT_NEAR(error.rotation.mean, 0.2, 1e-12);
  EXPECT_NEAR(error.rotation.deviation, std::sqrt(0.08 / 3.0), 1e-12);
  EXPECT_NEAR(error.rotation.max, 0.4, 1e-12);
  EXPECT_NEAR(error.rotation_squared.mean, 0.2 / 3.0, 1e-12);
}

TEST(RelationError, RotationIsTakenAlongTheShorterArc) {
  const Trajectory estimate({{0.0, {0, 0, 0}}, {1.0, {0, 0, -3.1}}});
  const auto error = relation_error(estimate, {{0.0, 1.0, {0.0, 0.0, 3.1}}});
  EXPECT_NEAR(error.rotation.mean, 2.0 * kPi - 6.2, 1e-12);
}

TEST(RelationError, InterpolatesTheEstimateWithoutOdometry) {
  const auto error = relation_error(straight_drive(4), {{0.25, 2.5, {2.25, 0.0, 0.0}}});
  EXPECT_NEAR(error.translation.max, 0.0, 1e-12);
}

TEST(RelationError, StandsStillOutsideTheEstimateWithoutOdometry) {
  const auto error = relation_error(straight_drive(3), {{-0.4, 2.5, {2.0, 0.0, 0.0}}});
  EXPECT_NEAR(error.translation.max, 0.0, 1e-12);
  EXPECT_EQ(error.extrapolated, 0U);
}

TEST(RelationError, CarriesBothNeighboursByOdometryAndBlendsThemByNearness) {
  // Odometry goes 2 m in the first second and then rests; the estimate knows only both ends, and
  // has turned the second by a quarter and put it 1 m aside: (2, 1), heading up.
  const Trajectory odometry({{0.0, {0, 0, 0}}, {1.0, {2, 0, 0}}, {4.0, {2, 0, 0}}});
  const Trajectory estimate({{0.0, {0, 0, 0}}, {4.0, {2, 1, 0.5 * kPi}}});
  // At 1 s the first says (2, 0, 0), the second (2, 1, quarter); the first is nearer, three to one.
  const Relation at_one{0.0, 1.0, {2.0, 0.25, 0.125 * kPi}};
  // At 0.5 s odometry is at (1, 0): (1, 0, 0) says the first; the second, carried back by 1 m
  // against its own heading, (2, 0, quarter).
  const Relation at_half{0.0, 0.5, {1.125, 0.0, 0.0625 * kPi}};
  const auto error = relation_error(estimate, {at_one, at_half}, odometry);
  ASSERT_EQ(error.differences.size(), 2U);
  EXPECT_NEAR(error.translation.max, 0.0, 1e-12);
  EXPECT_NEAR(error.rotation.max, 0.0, 1e-12);
}

TEST(RelationError, CarriesTheOnlyNeighbourOutsideTheEstimateAndSaysHowOften) {
  const Trajectory estimate({{2.0, {0, 0, 0.5 * kPi}}, {3.0, {0, 1, 0.5 * kPi}}});
  const auto error = relation_error(
      estimate, {{0.0, 5.0, {5.0, 0.0, 0.0}}, {2.0, 3.4, {1.4, 0.0, 0.0}}}, straight_drive(6));
  EXPECT_NEAR(error.translation.max, 0.0, 1e-12);
  EXPECT_NEAR(error.rotation.max, 0.0, 1e-12);
  EXPECT_EQ(error.extrapolated, 1U);
}

TEST(RelationError, UsesOnlyRelationsWithAPoseNearBothStamps) {
  const Trajectory sparse({{0.0, {}}, {1.0, {}}, {10.0, {}}});
  const std::vector<Relation> relations = {{0.0, 1.5, {}},    // on the limit
                                           {0.0, 1.51, {}},   // beyond
                                           {9.49, 10.0, {}},  // the first is beyond
                                           {-0.51, 0.0, {}},
                                           {0.4, 10.5, {}}};
  EXPECT_EQ(relation_error(sparse, relations).differences.size(), 2U);
  EXPECT_EQ(relation_error(sparse, relations).unusable, 3U);
  // With odometry it is odometry's poses that count.
  EXPECT_EQ(relation_error(straight_drive(2), relations, sparse).differences.size(), 2U);
  RelationErrorOptions wide;
  wide.max_distance = 0.52;
  EXPECT_EQ(relation_error(sparse, relations, {}, wide).unusable, 0U);
}

TEST(RelationError, ARigidMotionOfTheEstimateOrOfOdometryChangesNothing) {
  std::vector<StampedPose2> poses;
  std::vector<StampedPose2> moved;
  Pose2 pose;
  for (int i = 0; i < 50; ++i) {
    poses.push_back({0.7 * i, pose});
    moved.push_back({0.7 * i, Pose2{5.0, -3.0, 2.5} * pose});
    pose = pose * Pose2{0.3, 0.01, 0.2 * std::sin(0.5 * i)};
  }
  const std::vector<Relation> relations = {{1.0, 30.0, {4.0, 1.0, 0.5}}, {20.1, 3.3, {1, 2, 3}}};
  const Trajectory drive = straight_drive(40);
  const auto reference = relation_error(Trajectory(poses), relations, drive);
  for (const auto& error : {relation_error(Trajectory(moved), relations, drive),
                            relation_error(Trajectory(poses), relations, Trajectory([&] {
                                             auto turned = drive.poses();
                                             for (auto& stamped : turned) {
                                               stamped.pose = Pose2{1, 2, -2} * stamped.pose;
                                             }
                                             return turned;
                                           }()))}) {
    EXPECT_NEAR(error.translation.mean, reference.translation.mean, 1e-9);
    EXPECT_NEAR(error.rotation.mean, reference.rotation.mean, 1e-9);
  }
}

TEST(RelationError, NamesBothTimeRangesWhenNoneIsUsable) {
  const std::string text = error_text<EvaluationError>([] {
    (void)relation_error(straight_drive(3), {{200.0, 100.0, {}}});
  });
  EXPECT_TRUE(contains(text, "relations are from 100.000 to 200.000 s")) << text;
  EXPECT_TRUE(contains(text, "estimate from 0.000 to 2.000 s")) << text;
}

TEST(RelationError, SaysWhatIsEmpty) {
  const std::vector<Relation> relations = {{0.0, 1.0, {}}};
  EXPECT_EQ(error_text<EvaluationError>([&] { (void)relation_error({}, relations); }),
            "the estimate holds no poses");
  EXPECT_EQ(error_text<EvaluationError>([&] { (void)relation_error(straight_drive(2), {}); }),
            "there are no relations to compare with");
  EXPECT_EQ(error_text<EvaluationError>(
                [&] { (void)relation_error(straight_drive(2), relations, Trajectory()); }),
            "the odometry holds no poses");
  EXPECT_THROW((void)relation_error(straight_drive(2), relations, {}, {0.0}),
               std::invalid_argument);
}

/// Raw odometry of the Intel Research Lab log against its relations; the figures are those of an
/// independent computation.
TEST(RelationError, RawOdometryOfIntelIsAsBadAsItIsKnownToBe) {
  const std::string odometry_path = real_data("intel.odom.tum");
  const std::string relations_path = real_data("intel.relations");
  MATCHBOX_SKIP_WITHOUT(odometry_path);
  MATCHBOX_SKIP_WITHOUT(relations_path);
  const Trajectory odometry = read_tum(odometry_path);
  const auto relations = read_relations(relations_path);
  ASSERT_EQ(relations.size(), 2984U);
  for (const auto& error :
       {relation_error(odometry, relations, odometry), relation_error(odometry, relations)}) {
    EXPECT_EQ(error.differences.size(), 2907U);
    EXPECT_EQ(error.unusable, 77U);
    EXPECT_NEAR(error.translation.mean, 7.198, 0.001);
    EXPECT_NEAR(error.translation.deviation, 13.908, 0.001);
    EXPECT_NEAR(radians_to_degrees(error.rotation.mean), 39.80, 0.01);
    EXPECT_NEAR(radians_to_degrees(error.rotation.deviation), 53.56, 0.01);
  }
}

}  // namespace
}  // namespace matchbox_slam
