#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "slam/insertion.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/map_equality.hpp"

namespace matchbox_slam {
namespace {

Eigen::Isometry3d tilted_by(double tilt) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()));
}

// --- whether ---

/// A map in which laser 0 has inserted a scan at `kInserted`.
const Pose2 kInserted{2.0, -1.0, 0.7};

MapComponent map_with_a_wall() {
  MapComponent component{
      SlamMap(MapOptions{}, LikelihoodFieldOptions{}), {}, {{0, kInserted}}, 0.0};
  component.map.field.update({{{1.0, 0.0}, {-1.0, 0.0}}}, {});
  return component;
}

ScanOutcome matched(const Pose2& map_from_base, double score = 0.9) {
  ScanOutcome outcome;
  outcome.map_from_base = map_from_base;
  outcome.match.status = MatchStatus::kAccepted;
  outcome.match.score = score;
  return outcome;
}

ScanOutcome refused(MatchStatus status, Certainty certainty = Certainty::kSure) {
  ScanOutcome outcome = matched(kInserted * Pose2{5.0, 0.0, 0.0});
  outcome.match.status = status;
  outcome.certainty = certainty;
  return outcome;
}

class InsertionTest : public testing::Test {
 protected:
  [[nodiscard]] bool is_inserted(const ScanOutcome& outcome, int laser = 0, double tilt = 0.0,
                                 bool was_matched = true) const {
    ScanInput input;
    input.laser = laser;
    input.base_from_laser = tilted_by(tilt);
    return is_to_be_inserted(input, outcome, components_, was_matched, options_);
  }
  [[nodiscard]] bool is_inserted_after(const Pose2& moved, double score = 0.9) const {
    return is_inserted(matched(kInserted * moved, score));
  }

  MapComponents components_{{map_with_a_wall()}};
  SlamOptions options_;
};

TEST_F(InsertionTest, AScanIsInsertedAfterSomeMotion) {
  EXPECT_FALSE(is_inserted_after({}));
  for (const double direction : {0.0, 1.0, 2.5, -1.5}) {
    const double c = std::cos(direction);
    const double s = std::sin(direction);
    EXPECT_FALSE(is_inserted_after({0.299 * c, 0.299 * s, 0.0})) << direction;
    EXPECT_TRUE(is_inserted_after({0.301 * c, 0.301 * s, 0.0})) << direction;
  }
  EXPECT_FALSE(is_inserted_after({0.0, 0.0, 0.199}));
  EXPECT_TRUE(is_inserted_after({0.0, 0.0, 0.201}));
  EXPECT_TRUE(is_inserted_after({0.0, 0.0, -0.201}));
  options_.insert_distance = 0.0;
  components_.map().last_inserted[0] = {};
  EXPECT_TRUE(is_inserted(matched({}))) << "every scan";
}

/// Where it was seen the next scans may tell; not for ever.
TEST_F(InsertionTest, WhatWasSeenFromAPlaceThatIsHardlyKnownWaits) {
  const auto known_to = [](const Pose2& moved, double sigma) {
    ScanOutcome outcome = matched(kInserted * moved);
    outcome.covariance(0, 0) = sigma * sigma;
    return outcome;
  };
  EXPECT_TRUE(is_inserted(known_to({0.31, 0.0, 0.0}, 0.049)));
  EXPECT_FALSE(is_inserted(known_to({0.31, 0.0, 0.0}, 0.051)));
  EXPECT_FALSE(is_inserted(known_to({0.89, 0.0, 0.59}, 0.051)));
  EXPECT_TRUE(is_inserted(known_to({0.91, 0.0, 0.0}, 0.051))) << "three times the usual way";
  EXPECT_TRUE(is_inserted(known_to({0.0, 0.0, 0.61}, 0.051)));
  ScanOutcome odometry_alone = known_to({0.31, 0.0, 0.0}, 1.0);
  odometry_alone.match.score = 0.0;
  EXPECT_TRUE(is_inserted(odometry_alone)) << "which is all that there is";
}

TEST_F(InsertionTest, TheMapsFrameDoesNotMatter) {
  const Pose2 new_from_old{-40.0, 25.0, 2.9};
  components_.map().last_inserted[0] = new_from_old * kInserted;
  EXPECT_FALSE(is_inserted(matched(new_from_old * kInserted * Pose2{0.2, 0.2, 0.19})));
  EXPECT_TRUE(is_inserted(matched(new_from_old * kInserted * Pose2{0.22, 0.22, 0.19})));
}

TEST_F(InsertionTest, AScanThatTheMapHardlyKnowsIsInserted) {
  EXPECT_FALSE(is_inserted_after({}, 0.01)) << "by motion alone";
  options_.insert_overlap = 0.5;
  EXPECT_TRUE(is_inserted_after({}, 0.49));
  EXPECT_FALSE(is_inserted_after({}, 0.51));
}

TEST_F(InsertionTest, WhatDoesNotFitIsNot) {
  EXPECT_FALSE(is_inserted(refused(MatchStatus::kRejectedLowScore, Certainty::kUnmatched)));
  EXPECT_FALSE(is_inserted(refused(MatchStatus::kRejectedTooFewPoints)));
}

TEST_F(InsertionTest, NewGroundIsInsertedAsIfMatched) {
  ScanOutcome outcome = refused(MatchStatus::kRejectedLowScore, Certainty::kNewGround);
  EXPECT_TRUE(is_inserted(outcome));
  outcome.map_from_base = kInserted;
  EXPECT_FALSE(is_inserted(outcome)) << "after no motion";
}

TEST_F(InsertionTest, WhatStartsAMapIsInserted) {
  const ScanOutcome first = refused(MatchStatus::kRejectedNoReference);
  EXPECT_FALSE(is_inserted(first));
  components_.map().map = SlamMap(MapOptions{}, LikelihoodFieldOptions{});
  components_.map().last_inserted.clear();
  EXPECT_TRUE(is_inserted(first));
}

TEST_F(InsertionTest, ASecondaryLaserShowsWhatNoOtherHasSeen) {
  const ScanOutcome nowhere = refused(MatchStatus::kRejectedLowScore, Certainty::kUnmatched);
  EXPECT_TRUE(is_inserted(nowhere, 1));
  EXPECT_FALSE(is_inserted(nowhere, 1, 0.0, false)) << "where the base is nobody knows";
  EXPECT_FALSE(is_inserted(refused(MatchStatus::kRejectedTooFewPoints), 1));
  EXPECT_TRUE(is_inserted(matched(kInserted), 1)) << "though the base has not moved";
  components_.map().last_inserted[1] = kInserted;
  EXPECT_FALSE(is_inserted(nowhere, 1)) << "its second one";
  components_.map().last_inserted.clear();
  EXPECT_FALSE(is_inserted(nowhere, 1)) << "no other put the base anywhere";
}

TEST_F(InsertionTest, AMapThatIsKeptTakesNothingButFromALostRobot) {
  options_.update_map = false;
  EXPECT_FALSE(is_inserted_after({1.0, 0.0, 0.0}));
  EXPECT_FALSE(components_.begin_component(map_with_a_wall()));
  ASSERT_TRUE(components_.is_lost());
  EXPECT_TRUE(is_inserted_after({1.0, 0.0, 0.0})) << "which goes into a map of its own";
}

/// Which sees twice as far before its beams leave the band of heights.
TEST_F(InsertionTest, ALaserThatIsTiltedLessSeesMore) {
  const auto insert = [this](int laser, double tilt) {
    components_.map().key_scans.add(MeasuredScan{{}, tilted_by(tilt), {}, {}}, laser, kInserted);
  };
  const ScanOutcome here = matched(kInserted);
  insert(0, 0.1);
  EXPECT_FALSE(is_inserted(here, 0, 0.1));
  EXPECT_FALSE(is_inserted(here, 0, 0.051));
  EXPECT_TRUE(is_inserted(here, 0, 0.049));
  EXPECT_TRUE(is_inserted(here, 0, 0.0));
  insert(1, 0.0);
  EXPECT_TRUE(is_inserted(here, 0, 0.049)) << "of another laser";
  components_.map().key_scans.add(PointScan{}, 0, kInserted);
  EXPECT_TRUE(is_inserted(here, 0, 0.049)) << "whose tilt is not known";
  insert(0, 0.009);
  EXPECT_FALSE(is_inserted(here, 0, 0.0)) << "it saw all";
}

// --- where ---

/// What two lasers saw in rooms, and a mapping that it goes into.
class InsertTest : public testing::Test {
 protected:
  InsertTest() {
    const PlacedScans keys = drive_through_rooms(3);
    ScanInput input;
    input.scan = keys[0].scan->measured()->scan;
    ScanProjector projector;
    std::map<int, SecondaryScan> further;
    further[2] = {*keys[1].scan->measured(), kThereFromBase};
    bundle_.assign(input, keys[0].scan->measured()->base_from_laser, {}, options_.scan, further,
                   projector);
    outcome_.map_from_base = {3.0, 4.0, 1.0};
    outcome_.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  }

  void insert_scans() { insert(bundle_, 1, mapping_, outcome_); }

  /// As the leading scan's and the further one's.
  void expect_both(const PlacedScan& leading, const PlacedScan& further) const {
    EXPECT_EQ(leading.scan->laser(), 1);
    EXPECT_EQ(leading.map_from_base, outcome_.map_from_base);
    EXPECT_EQ(leading.scan->measured()->scan.ranges, bundle_.primary().scan.ranges);
    EXPECT_EQ(further.scan->laser(), 2);
    EXPECT_EQ(further.map_from_base, outcome_.map_from_base * kThereFromBase);
    EXPECT_EQ(further.scan->measured()->scan.ranges,
              bundle_.secondary().at(2).measured.scan.ranges);
  }

  const Pose2 kThereFromBase{-0.1, 0.02, 0.05};
  EngineOptions options_;
  ScanBundle bundle_;
  ScanOutcome outcome_;
  Mapping mapping_{options_};
};

TEST_F(InsertTest, EachLasersScanIsAKeyScanWhereItWasTaken) {
  insert_scans();
  EXPECT_TRUE(outcome_.inserted);
  EXPECT_EQ(outcome_.left_out, 0U);
  const PlacedScans& keys = mapping_.components().map().key_scans.all();
  ASSERT_EQ(keys.size(), 2U);
  expect_both(keys[0], keys[1]);
}

TEST_F(InsertTest, WhatTheMapHasNoRoomForIsCountedForEachLaser) {
  insert_scans();
  outcome_ = {};
  outcome_.map_from_base = {1e7, 0.0, 0.0};
  outcome_.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  insert_scans();
  EXPECT_FALSE(outcome_.inserted);
  EXPECT_EQ(outcome_.left_out, 2U);
  EXPECT_EQ(mapping_.components().map().key_scans.size(), 2U);
}

TEST_F(InsertTest, AScanThatIsDrawnOverTheMapIsNoKeyScan) {
  insert_scans();
  const SlamMap before = mapping_.lasting();
  outcome_.inserted = false;
  draw_over(bundle_, 1, mapping_, outcome_);
  EXPECT_FALSE(outcome_.inserted);
  EXPECT_EQ(mapping_.components().map().key_scans.size(), 2U);
  EXPECT_TRUE(same_map(mapping_.lasting(), before));
  EXPECT_EQ(mapping_.temporary().last_drawn().at(1), outcome_.map_from_base);
  EXPECT_EQ(mapping_.temporary().last_drawn().at(2), outcome_.map_from_base * kThereFromBase);
}

/// A robot that localises in the map of a drive, where it was at its third key scan.
class DrawnOverTest : public testing::Test {
 protected:
  DrawnOverTest() {
    options_.slam.update_map = false;
    mapping_.set_options(options_);
    for (std::size_t i = 0; i < 4; ++i) {
      mapping_.insert(scan(i), keys_[i], Eigen::Matrix3d::Zero());
    }
    outcome_ = matched(keys_[2].map_from_base);
  }
  [[nodiscard]] const PointScan& scan(std::size_t key) const { return *keys_[key].scan->points(); }
  [[nodiscard]] bool is_drawn() const {
    return is_to_be_drawn_over(scan(2), 0, outcome_, mapping_);
  }

  const PlacedScans keys_ = drive_through_rooms(4);
  EngineOptions options_;
  Mapping mapping_{options_};
  ScanOutcome outcome_;
};

TEST_F(DrawnOverTest, AfterSomeMotionWhereItMatches) {
  EXPECT_TRUE(is_drawn()) << "the first one at once";
  mapping_.draw_over(scan(2), 0, keys_[2].map_from_base * Pose2{0.29, 0.0, 0.0});
  EXPECT_FALSE(is_drawn());
  mapping_.draw_over(scan(2), 0, keys_[2].map_from_base * Pose2{0.31, 0.0, 0.0});
  EXPECT_TRUE(is_drawn());
  outcome_.match.status = MatchStatus::kRejectedLowScore;
  EXPECT_FALSE(is_drawn());
}

TEST_F(DrawnOverTest, NotOutsideOfTheMap) {
  outcome_.map_from_base = Pose2{50.0, 0.0, 0.0} * keys_[2].map_from_base;
  EXPECT_FALSE(is_drawn());
  mapping_.draw_over(scan(2), 0, outcome_.map_from_base);
  outcome_.map_from_base = outcome_.map_from_base * Pose2{0.5, 0.0, 0.0};
  EXPECT_FALSE(is_drawn()) << "what it has drawn there is not of the map";
}

TEST_F(DrawnOverTest, WhereMostOfItEndsOnKnownGround) {
  for (const std::size_t tenths : {3, 7}) {
    PointScan partly = scan(2);
    for (std::size_t i = 0; i < partly.points.size(); ++i) {
      if (i % 10 < tenths) {  // far outside of the map
        partly.points[i].position.x() += 60.0;
      }
    }
    EXPECT_EQ(is_to_be_drawn_over(partly, 0, outcome_, mapping_), tenths == 3);
  }
}

TEST_F(DrawnOverTest, NotWhileItMapsOrIsLost) {
  options_.slam.update_map = true;
  mapping_.set_options(options_);
  EXPECT_FALSE(is_drawn());
  options_.slam.update_map = false;
  mapping_.set_options(options_);
  static_cast<void>(mapping_.begin_component(3.0));
  EXPECT_FALSE(is_drawn());
}

}  // namespace
}  // namespace matchbox_slam
