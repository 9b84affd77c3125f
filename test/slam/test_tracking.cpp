#include <gtest/gtest.h>

#include "matchbox_slam/slam/tracking.hpp"

namespace matchbox_slam {
namespace {

WeighedMatch match_of(double score, Certainty certainty = Certainty::kSure) {
  WeighedMatch weighed;
  weighed.match.status = certainty == Certainty::kDoubtful ? MatchStatus::kRejectedContradiction
                                                           : MatchStatus::kAccepted;
  weighed.match.score = score;
  weighed.fit = score;
  weighed.certainty = certainty;
  return weighed;
}

WeighedMatch jump() {
  WeighedMatch weighed = match_of(0.9, Certainty::kSecondLook);
  weighed.jumped = true;
  return weighed;
}

class TrackingTest : public testing::Test {
 protected:
  /// A scan a tenth of a second and half a metre after the one before.
  Tracking::Held follow(const WeighedMatch& match) {
    ++scans_;
    return tracking_.follow(match, 0.1 * scans_, 0.1, 0.5, {0.5 * scans_, 0.0, 0.0}, options_);
  }
  void hold() { tracking_.hold({0, PlacedScan{}}); }

  EngineOptions options_;
  Tracking tracking_;
  int scans_ = 0;
};

TEST_F(TrackingTest, LearnsTheUsualScoreFromMatchesThatNothingSpeaksAgainst) {
  static_cast<void>(follow(match_of(0.8)));
  EXPECT_DOUBLE_EQ(tracking_.usual_score(), 0.8);
  static_cast<void>(follow(match_of(0.6)));
  EXPECT_DOUBLE_EQ(tracking_.usual_score(), 0.78);
  static_cast<void>(follow(jump()));
  static_cast<void>(follow(match_of(0.1)));
  EXPECT_DOUBLE_EQ(tracking_.usual_score(), 0.78);
  EXPECT_TRUE(tracking_.expected().is_in_doubt);
}

TEST_F(TrackingTest, TellsTheWaySinceAMatchThatTheMapDoesNotContradict) {
  WeighedMatch contradicted = match_of(0.9);
  contradicted.match.contradiction = 0.2;
  static_cast<void>(follow(contradicted));
  EXPECT_DOUBLE_EQ(tracking_.expected().contradicted_way, 0.5);
  contradicted.overruled = true;
  static_cast<void>(follow(contradicted));
  EXPECT_DOUBLE_EQ(tracking_.expected().contradicted_way, 1.0);
  static_cast<void>(follow(match_of(0.9, Certainty::kDoubtful)));
  EXPECT_DOUBLE_EQ(tracking_.expected().contradicted_way, 1.5) << "one that is none";
  static_cast<void>(follow(match_of(0.9)));
  EXPECT_DOUBLE_EQ(tracking_.expected().contradicted_way, 0.0);
  static_cast<void>(follow(contradicted));
  tracking_.believe();
  EXPECT_DOUBLE_EQ(tracking_.expected().contradicted_way, 0.0);
}

TEST_F(TrackingTest, LearnsNoUsualScoreFromWhatTheMapContradicts) {
  static_cast<void>(follow(match_of(0.8)));
  WeighedMatch overruled = match_of(0.2);
  overruled.overruled = true;
  static_cast<void>(follow(overruled));
  EXPECT_DOUBLE_EQ(tracking_.usual_score(), 0.8);
}

TEST_F(TrackingTest, GivesOutWhatWasHeldOnceThePlaceIsConfirmed) {
  EXPECT_TRUE(follow(jump()).confirmed.empty());
  hold();
  EXPECT_TRUE(follow(match_of(0.9)).confirmed.empty());
  hold();
  const Tracking::Held held = follow(match_of(0.9));
  EXPECT_EQ(held.confirmed.size(), 2U);
  EXPECT_FALSE(held.is_any_dropped);
  EXPECT_TRUE(tracking_.held().empty());
  EXPECT_FALSE(tracking_.doubt().doubts);
}

TEST_F(TrackingTest, DropsWhatWasHeldWhereAScanMatchesNowhere) {
  static_cast<void>(follow(jump()));
  hold();
  const Tracking::Held held = follow(match_of(0.0, Certainty::kDoubtful));
  EXPECT_TRUE(held.confirmed.empty());
  EXPECT_TRUE(held.is_any_dropped);
  EXPECT_TRUE(tracking_.held().empty());
  EXPECT_FALSE(follow(match_of(0.0, Certainty::kDoubtful)).is_any_dropped);
}

TEST_F(TrackingTest, DropsWhatWasHeldBeforeAnotherJump) {
  static_cast<void>(follow(jump()));
  hold();
  EXPECT_TRUE(follow(jump()).is_any_dropped);
  EXPECT_TRUE(tracking_.doubt().is_provisional);
}

TEST_F(TrackingTest, BelievesWhatItIsTold) {
  static_cast<void>(follow(jump()));
  hold();
  tracking_.believe();
  EXPECT_TRUE(tracking_.held().empty());
  EXPECT_FALSE(tracking_.expected().is_in_doubt);
}

}  // namespace
}  // namespace matchbox_slam
