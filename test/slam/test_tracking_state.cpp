#include <gtest/gtest.h>

#include "matchbox_slam/slam/tracking_state.hpp"

namespace matchbox_slam {
namespace {

WeighedMatch good(Certainty certainty = Certainty::kSure) {
  WeighedMatch match;
  match.match.status = MatchStatus::kAccepted;
  match.match.score = 0.8;
  match.fit = 0.8;
  match.certainty = certainty;
  match.jumped = certainty == Certainty::kSecondLook;
  return match;
}

WeighedMatch doubtful(double contradiction) {
  WeighedMatch match;
  match.match.status = MatchStatus::kRejectedLowScore;
  match.match.contradiction = contradiction;
  match.certainty = Certainty::kDoubtful;
  return match;
}

class TrackingDoubtTest : public testing::Test {
 protected:
  /// Ten scans a second, 6 cm apart.
  void follow(const WeighedMatch& match, double usual_score = 0.0) {
    stamp_ += 0.1;
    x_ += 0.06;
    doubt_.follow(match, stamp_, 0.06, {x_, 0.0, 0.0}, usual_score, {}, {});
  }

  double stamp_ = 100.0;
  double x_ = 0.0;
  TrackingDoubt doubt_;
};

TEST_F(TrackingDoubtTest, GoodMatchesAreTracking) {
  follow(good());
  EXPECT_FALSE(doubt_.doubts);
}

TEST_F(TrackingDoubtTest, ADoubtIsOverAfterTwoScansWithMotionBetween) {
  follow(doubtful(0.5));
  EXPECT_TRUE(doubt_.doubts);
  follow(good());
  EXPECT_TRUE(doubt_.is_provisional);
  for (int i = 0; i < 3; ++i) {  // 0.18 m: confirmed once
    follow(good());
  }
  EXPECT_TRUE(doubt_.doubts);
  follow(good());  // 0.24 m
  EXPECT_FALSE(doubt_.doubts);
}

/// A place in a corridor has rivals all along it.
TEST_F(TrackingDoubtTest, APlaceWithRivalsIsConfirmed) {
  WeighedMatch in_a_corridor = good();
  in_a_corridor.match.rival_share = 1.0;
  follow(doubtful(0.5));
  for (int i = 0; i < 5; ++i) {
    follow(in_a_corridor);
  }
  EXPECT_FALSE(doubt_.doubts);
}

TEST_F(TrackingDoubtTest, ARobotAtRestConfirmsNothing) {
  follow(good(Certainty::kSecondLook));
  for (int i = 0; i < 100; ++i) {
    doubt_.follow(good(), stamp_ += 0.1, 0.0, {x_, 0.0, 0.0}, 0.0, {}, {});
  }
  EXPECT_TRUE(doubt_.is_provisional);
}

TEST_F(TrackingDoubtTest, APoorMatchConfirmsNothing) {
  follow(good(Certainty::kSecondLook));
  WeighedMatch poor = good();
  poor.match.contradiction = 0.2;
  for (int i = 0; i < 20; ++i) {
    follow(poor);
  }
  EXPECT_TRUE(doubt_.is_provisional);
}

/// Half a metre of scans that contradict the map, whatever confirmed it before.
TEST_F(TrackingDoubtTest, AProvisionalPoseThatIsContradictedIsLost) {
  follow(good(Certainty::kSecondLook));
  follow(good());
  follow(good());  // 0.12 m: confirmed once
  WeighedMatch contradicted = good();
  contradicted.match.contradiction = 0.2;
  for (int i = 0; i < 11; ++i) {  // one of two has moved 0.1 m
    follow(contradicted);
    EXPECT_FALSE(doubt_.is_lost(stamp_, {})) << i;
  }
  EXPECT_TRUE(doubt_.is_provisional);
  follow(contradicted);
  EXPECT_TRUE(doubt_.is_lost(stamp_, {}));
}

TEST_F(TrackingDoubtTest, TheWayThatConfirmsAPoseBeginsAnewWhereItIsContradicted) {
  follow(good(Certainty::kSecondLook));
  WeighedMatch contradicted = good();
  contradicted.match.contradiction = 0.2;
  WeighedMatch middling = good();
  middling.fit = 0.3;
  for (int i = 0; i < 80; ++i) {  // 4.8 m
    follow(middling);
  }
  follow(contradicted);
  EXPECT_FALSE(doubt_.is_lost(stamp_ + 10.0, {}));
  for (int i = 0; i < 83; ++i) {  // 4.98 m
    follow(middling);
    EXPECT_TRUE(doubt_.is_provisional) << i;
  }
  follow(middling);
  EXPECT_FALSE(doubt_.doubts);
}

/// A robot that is being carried fits a little anywhere.
TEST_F(TrackingDoubtTest, AMatchFarBelowWhatIsUsualConfirmsNothing) {
  WeighedMatch middling = good();
  middling.fit = 0.6;
  follow(good(Certainty::kSecondLook));
  for (int i = 0; i < 20; ++i) {
    follow(middling, 0.95);
  }
  EXPECT_TRUE(doubt_.is_provisional);
  for (int i = 0; i < 4; ++i) {
    follow(middling, 0.7);
  }
  EXPECT_FALSE(doubt_.doubts);
}

TEST_F(TrackingDoubtTest, ASecondLookThatFindsThePredictionIsNoDoubt) {
  WeighedMatch found = good(Certainty::kSecondLook);
  found.jumped = false;
  follow(found);
  EXPECT_FALSE(doubt_.doubts);
}

TEST_F(TrackingDoubtTest, AFitThatIsMiddlingIsConfirmedByALongWay) {
  WeighedMatch middling = good();
  middling.fit = 0.3;
  follow(doubtful(0.0));
  for (int i = 0; i < 84; ++i) {  // 5.04 m, the first of which make it provisional
    EXPECT_TRUE(doubt_.doubts) << i;
    follow(middling);
  }
  EXPECT_TRUE(doubt_.is_provisional);
  follow(middling);
  EXPECT_FALSE(doubt_.doubts);
}

TEST_F(TrackingDoubtTest, NewGroundLeadsOutOfNoDoubt) {
  WeighedMatch nothing = doubtful(0.0);
  nothing.certainty = Certainty::kNewGround;
  follow(nothing);
  EXPECT_FALSE(doubt_.doubts) << "a corner, without a doubt before";
  follow(doubtful(0.0));
  for (int i = 0; i < 84; ++i) {  // 5.04 m
    follow(nothing);
  }
  EXPECT_TRUE(doubt_.is_lost(stamp_, {}));
}

TEST_F(TrackingDoubtTest, AfterASecondOfContradictionsTheRobotIsLost) {
  for (int i = 0; i < 10; ++i) {
    follow(doubtful(0.5));
    EXPECT_FALSE(doubt_.is_lost(stamp_, {})) << i;
  }
  follow(doubtful(0.5));
  EXPECT_TRUE(doubt_.is_lost(stamp_ + 1e-6, {}));
}

TEST_F(TrackingDoubtTest, SomethingThatCoversTheViewIsNotBeingLost) {
  for (int i = 0; i < 50; ++i) {  // 3 m
    follow(doubtful(0.0));
  }
  EXPECT_FALSE(doubt_.is_lost(stamp_, {}));
  for (int i = 0; i < 60; ++i) {  // 6.6 m
    follow(doubtful(0.0));
  }
  EXPECT_TRUE(doubt_.is_lost(stamp_, {}));
}

/// Too little of each scan contradicts the map to count, and every scan does a little.
TEST_F(TrackingDoubtTest, OnlyWhereHardlyAnythingContradictsALongDoubtIsBlind) {
  for (const double contradiction : {0.0, 0.01, 0.03, 0.09}) {
    doubt_ = {};
    for (int i = 0; i < 90; ++i) {  // 5.4 m
      follow(doubtful(contradiction));
    }
    EXPECT_TRUE(doubt_.is_lost(stamp_, {})) << contradiction;
    EXPECT_EQ(doubt_.is_blind({}), contradiction < 0.02) << contradiction;
  }
}

/// However many others say nothing.
TEST_F(TrackingDoubtTest, ADoubtWithFiveContradictionsIsNotBlind) {
  for (int i = 0; i < 200; ++i) {
    follow(doubtful(i < 5 ? 0.2 : 0.0));
  }
  EXPECT_FALSE(doubt_.is_blind({}));
  doubt_ = {};
  for (int i = 0; i < 200; ++i) {
    follow(doubtful(i < 4 ? 0.2 : 0.0));
  }
  EXPECT_TRUE(doubt_.is_blind({}));
}

TEST_F(TrackingDoubtTest, TimeWithoutScansSaysNothing) {
  // 0.3 s of scans, 2 s apart from 0.3 s more, as of a laser that nods.
  for (int i = 0; i < 3; ++i) {
    follow(doubtful(0.5));
  }
  stamp_ += 2.0;
  doubt_.pass(2.1);
  for (int i = 0; i < 3; ++i) {
    follow(doubtful(0.5));
  }
  EXPECT_FALSE(doubt_.is_lost(stamp_, {}));
  for (int i = 0; i < 2; ++i) {
    follow(doubtful(0.5));
  }
  EXPECT_TRUE(doubt_.is_lost(stamp_, {}));
}

}  // namespace
}  // namespace matchbox_slam
