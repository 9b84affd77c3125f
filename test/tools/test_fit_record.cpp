#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "tools/fit_record.hpp"

namespace matchbox_slam {
namespace {

using Texts = std::vector<std::string>;

ScanOutcome outcome_of(double stamp) {
  ScanOutcome outcome;
  outcome.evidence.mean = 2.8;
  outcome.stamp = stamp;
  outcome.match.status = MatchStatus::kAccepted;
  outcome.match.score = 0.8;
  outcome.map_from_base = {stamp, 0.0, 0.0};
  outcome.odom_from_base = Pose2{stamp, 0.0, 0.0};
  return outcome;
}

TEST(FitRecord, HasNothingToSayOfAGoodRun) {
  FitRecord record;
  EXPECT_EQ(record.warnings(), Texts{});
  for (int k = 0; k < 100; ++k) {
    ScanOutcome outcome = outcome_of(0.1 * k);
    if (k > 40 && k < 45) {
      outcome.match.status = MatchStatus::kRejectedLowScore;
      outcome.state = TrackingState::kDoubt;
    }
    record.add(outcome);
  }
  EXPECT_EQ(record.warnings(), Texts{});
}

TEST(FitRecord, SaysWhyFewScansMatch) {
  FitRecord record;
  for (int k = 0; k < 100; ++k) {
    ScanOutcome outcome = outcome_of(0.1 * k);
    if (k % 2 == 0) {
      outcome.match.status =
          k < 50 ? MatchStatus::kRejectedLowScore : MatchStatus::kRejectedUnexpected;
    }
    record.add(outcome);
  }
  ASSERT_FALSE(record.warnings().empty());
  EXPECT_TRUE(contains(record.warnings().front(), "25 fit nowhere near the prediction"))
      << record.warnings().front();
  EXPECT_TRUE(contains(record.warnings().front(), "25 fit where their motion hardly leads to"))
      << record.warnings().front();
}

TEST(FitRecord, SaysThatMatchesArePoorButNothingOfAMatcherThatMatchesNothing) {
  for (const double score : {0.4, 0.0}) {
    FitRecord record;
    for (int k = 0; k < 100; ++k) {
      ScanOutcome outcome = outcome_of(0.1 * k);
      outcome.match.score = score;
      outcome.evidence.mean = 0.5;
      record.add(outcome);
    }
    EXPECT_EQ(record.warnings().size(), score > 0.0 ? 1U : 0U);
  }
}

TEST(FitRecord, WarnsOfLessEvidenceThanARightMapGives) {
  for (const double evidence : {1.2, 0.8}) {
    FitRecord record;
    for (int k = 0; k < 100; ++k) {
      ScanOutcome outcome = outcome_of(0.1 * k);
      outcome.match.score = 0.9;
      outcome.evidence.mean = evidence;
      record.add(outcome);
    }
    EXPECT_EQ(record.warnings().size(), evidence < 1.0 ? 1U : 0U);
  }
}

TEST(FitRecord, SaysForHowLongItWasNotSure) {
  FitRecord record;
  for (int k = 0; k <= 100; ++k) {
    ScanOutcome outcome = outcome_of(0.1 * k);
    outcome.state = k >= 20 && k < 50 ? TrackingState::kLost : TrackingState::kTracking;
    record.add(outcome);
  }
  EXPECT_EQ(
      record.warnings(),
      Texts{"for 3.0 of 10.0 s it was not sure where the robot is, the longest 3.0 s from the "
            "scan of 2.000 s on; scans.csv has the state of each scan"});
  EXPECT_EQ(record.lost(), 30U);
  EXPECT_FALSE(record.is_mostly_lost());
}

TEST(FitRecord, CountsTheLostAmongTheScansOfTheMainLaserAlone) {
  FitRecord record;
  EXPECT_FALSE(record.is_mostly_lost()) << "of no scan there is nothing to say";
  for (int k = 0; k < 100; ++k) {
    ScanOutcome outcome = outcome_of(0.1 * k);
    outcome.state = k < 9 ? TrackingState::kTracking : TrackingState::kLost;
    record.add(outcome);
    outcome.is_of_secondary_laser = true;
    record.add(outcome);
  }
  EXPECT_EQ(record.lost(), 91U);
  EXPECT_TRUE(record.is_mostly_lost());
}

TEST(FitRecord, SaysThatThePosesJumpAgainstTheOdometry) {
  FitRecord record;
  for (int k = 0; k <= 100; ++k) {
    ScanOutcome outcome = outcome_of(0.1 * k);
    outcome.map_from_base.y = k % 4 == 0 ? 0.06 : 0.0;
    record.add(outcome);
  }
  EXPECT_EQ(
      record.warnings(),
      Texts{"in 50 of 100 steps from scan to scan the pose jumps by more than 5 cm against "
            "the odometry: is the laser's place in tf right, are the stamps, or is the "
            "odometry so bad? --matcher odometry_only shows what odometry alone makes of it"});
  EXPECT_TRUE(contains(record.warnings("by --laser-pose").at(0),
                       "is the laser's place by --laser-pose right, are the stamps"));
  ScanOutcome beside = outcome_of(10.05);
  beside.is_of_secondary_laser = true;
  record.add(beside);
  EXPECT_TRUE(contains(record.warnings().front(), "do the lasers disagree"));
  FitRecord leaping;  // of made-up stamps: no robot drives half a metre in a tenth of a second
  for (int k = 0; k <= 100; ++k) {
    ScanOutcome outcome = outcome_of(0.1 * k);
    outcome.odom_from_base = Pose2{0.5 * k, 0.0, 0.0};
    outcome.map_from_base = {0.5 * k, k % 4 == 0 ? 0.06 : 0.0, 0.0};
    leaping.add(outcome);
  }
  EXPECT_EQ(leaping.warnings(), Texts{});
  FitRecord sparse;  // between scans seconds apart odometry may err by that
  for (int k = 0; k <= 100; ++k) {
    ScanOutcome outcome = outcome_of(3.0 * k);
    outcome.map_from_base.y = k % 4 == 0 ? 0.06 : 0.0;
    sparse.add(outcome);
  }
  EXPECT_EQ(sparse.warnings(), Texts{});
}

}  // namespace
}  // namespace matchbox_slam
