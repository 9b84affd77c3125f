#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "slam/common_ground.hpp"
#include "slam/pose_distance.hpp"
#include "slam/pose_hypotheses.hpp"
#include "slam/prior_odds.hpp"
#include "slam/scan_evidence.hpp"
#include "slam/wall_scan.hpp"

namespace matchbox_slam {
namespace {

using Hypothesis = PoseHypothesis;
using Fork = HypothesesFork;
using State = HypothesesState;
using Outcome = PoseHypotheses::Outcome;
using Verdict = PoseHypotheses::Verdict;

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr double kInterval = 0.5;  // [s] from scan to scan

LaserOptions laser() {
  LaserOptions options;
  options.beams = 360;
  return options;
}

/// A building that was mapped, and a robot that drives through it again.
class Rooms {
 public:
  Rooms() {
    for (int i = 0; i < 50; ++i) {
      const double stamp = 0.5 + i;
      keys_.push_back(placed(look(stamp, static_cast<std::uint64_t>(i)), truth(stamp)));
      insert_scan(*keys_.back().scan->points(), keys_.back().map_from_base, {}, map_);
    }
  }

  [[nodiscard]] Pose2 truth(double time) const { return motion_.pose(time); }
  [[nodiscard]] PointScan look(double time, std::uint64_t seed = 1000) const {
    return look_around(world_, laser(), truth(time),
                       mix_seed(seed, static_cast<std::uint64_t>(10.0 * time)));
  }
  [[nodiscard]] const SlamMap& map() const { return map_; }
  [[nodiscard]] const PlacedScans& keys() const { return keys_; }

 private:
  World world_ = make_rooms_world(3);
  RobotMotion motion_ = drive(world_.route(), {});
  SlamMap map_{MapOptions{}, LikelihoodFieldOptions{}};
  PlacedScans keys_;
};

const Rooms& rooms() {
  static const Rooms kRooms;
  return kRooms;
}

/// A robot that moved like that is predicted there.
MotionPrediction prediction(const Pose2& there, const Pose2& moved) {
  MotionPrediction predicted;
  predicted.fixed_from_base = there;
  predicted.covariance = prior_of(0.05, 0.03);
  predicted.search_covariance = predicted.covariance;
  predicted.motion.previous_from_current = moved;
  predicted.motion.covariance = predicted.covariance;
  predicted.motion.unscaled = predicted.covariance;
  return predicted;
}

MatchResult match_at(const Pose2& there, MatchStatus status = MatchStatus::kAccepted) {
  MatchResult match;
  match.map_from_base = there;
  match.covariance = prior_of(0.01, 0.005);
  match.score = 0.8;
  match.status = status;
  return match;
}

/// A drive through the rooms, told to be where the leading hypothesis is.
struct LedDrive {
  PoseHypotheses hypotheses;
  HypothesisOptions options;
  double time = 5.0;
  Pose2 leading = rooms().truth(5.0);
  double seconds = kInterval;  ///< that are said to have passed
  PlacedScans keys = rooms().keys();

  /// The next scan, matched where its motion leads to, or as told.
  Outcome go_on(MatchStatus status = MatchStatus::kAccepted) {
    return follow(rooms().look(time + kInterval), status);
  }

  Outcome follow(const PointScan& scan, MatchStatus status = MatchStatus::kAccepted,
                 const Pose2* by_velocity = nullptr) {
    const Pose2 moved = rooms().truth(time).inverse() * rooms().truth(time + kInterval);
    time += kInterval;
    leading = leading * moved;
    const MotionPrediction predicted = prediction(leading, moved);
    std::optional<MotionPrediction> steady;
    if (by_velocity != nullptr) {
      steady = prediction(*by_velocity, moved);
    }
    Outcome outcome = hypotheses.follow(
        {scan, rooms().map(), rooms().map(), keys, keys, seconds, predicted, steady},
        match_at(leading, status), options);
    leading = outcome.match.map_from_base;
    return outcome;
  }

  [[nodiscard]] Pose2 truth() const { return rooms().truth(time); }
};

/// Off by more than a motion may be, and in the same room.
Pose2 off_by_much(const Pose2& pose) { return shifted(pose, {0.5, -0.3, 0.25}); }

void expect_same(const State& a, const State& b) {
  EXPECT_EQ(a.elsewhere, b.elsewhere);
  EXPECT_EQ(a.profile, b.profile);
  ASSERT_EQ(a.fork.has_value(), b.fork.has_value());
  if (a.fork) {
    EXPECT_EQ(a.fork->key_scans, b.fork->key_scans);
    EXPECT_EQ(a.fork->inserted, b.fork->inserted);
    EXPECT_EQ(a.fork->undecided, b.fork->undecided);
    EXPECT_EQ(a.fork->searched, b.fork->searched);
  }
  ASSERT_EQ(a.others.size(), b.others.size());
  for (std::size_t i = 0; i < a.others.size(); ++i) {
    EXPECT_EQ(a.others[i].map_from_base, b.others[i].map_from_base);
    EXPECT_EQ(a.others[i].log_odds, b.others[i].log_odds);
    EXPECT_EQ(a.others[i].key_scans, b.others[i].key_scans);
  }
}

void expect_at(const Pose2& pose, const Pose2& truth) {
  EXPECT_LT(distance(pose, truth), 0.02);
  EXPECT_LT(std::abs(wrap_angle(pose.theta - truth.theta)), 0.01);
}

TEST(PoseHypotheses, AreNoneAtFirst) {
  const PoseHypotheses hypotheses;
  EXPECT_FALSE(hypotheses.is_forked());
  EXPECT_FALSE(hypotheses.is_in_doubt({}));
  EXPECT_TRUE(hypotheses.state().others.empty());
  EXPECT_EQ(hypotheses.state().elsewhere, kNever);
}

TEST(PoseHypotheses, KeepNothingWhileScansFit) {
  LedDrive drive;
  for (int i = 0; i < 20; ++i) {
    const Outcome outcome = drive.go_on();
    ASSERT_EQ(outcome.verdict, Verdict::kLeads) << i;
    ASSERT_FALSE(outcome.is_jump) << i;
    ASSERT_GT(outcome.evidence.mean, 1.5) << i;
    ASSERT_LT(distance(outcome.match.map_from_base, drive.truth()), 1e-9) << i;
    ASSERT_FALSE(drive.hypotheses.is_forked()) << i;
    ASSERT_TRUE(drive.hypotheses.state().others.empty()) << i;
    ASSERT_FALSE(drive.hypotheses.is_in_doubt(drive.options)) << i;
  }
}

TEST(PoseHypotheses, OvertakeALeadingPoseThatIsWrong) {
  LedDrive drive;
  drive.leading = off_by_much(drive.leading);
  const Outcome outcome = drive.go_on();
  ASSERT_EQ(outcome.verdict, Verdict::kOvertaken)
      << "a scan decides that contradicts one and fits another";
  EXPECT_TRUE(outcome.match.accepted());
  EXPECT_LT(outcome.evidence.mean, 0.5) << "of the one that led before";
  expect_at(outcome.match.map_from_base, drive.truth());
}

TEST(PoseHypotheses, TakeTwoScansToLeadWhereNothingContradictsTheOneThatLeads) {
  LedDrive drive;
  drive.seconds = 2.0;
  const Pose2 right = drive.truth();
  drive.leading = {500.0, 0.0, 0.0};  // where nothing is known
  drive.hypotheses = PoseHypotheses({Fork{50, 0, 0.0, 0.0}, {{right, -kPriorAgainstJump}}});
  Outcome outcome = drive.go_on();
  EXPECT_EQ(outcome.verdict, Verdict::kLeads) << "rooms are alike";
  EXPECT_NEAR(drive.hypotheses.state().others.front().log_odds, 6.0 - kPriorAgainstJump, 1e-9);
  outcome = drive.go_on();
  ASSERT_EQ(outcome.verdict, Verdict::kOvertaken);
  expect_at(outcome.match.map_from_base, drive.truth());
}

TEST(PoseHypotheses, AreInDoubtUntilTheOddsDecide) {
  LedDrive drive;
  drive.options.decisive = 6.0;  // so that one scan does not decide
  drive.leading = off_by_much(drive.leading);
  Outcome outcome = drive.go_on();
  EXPECT_TRUE(drive.hypotheses.is_forked());
  EXPECT_TRUE(drive.hypotheses.is_in_doubt(drive.options));
  int scans = 1;
  for (; outcome.verdict == Verdict::kLeads && scans < 6; ++scans) {
    ASSERT_GT(distance(outcome.match.map_from_base, drive.truth()), 0.4);
    outcome = drive.go_on();
  }
  ASSERT_EQ(outcome.verdict, Verdict::kOvertaken);
  EXPECT_GE(scans, 2);
  expect_at(outcome.match.map_from_base, drive.truth());
}

TEST(PoseHypotheses, TheOneThatLedBeforeGoesOnAndIsSoonRefuted) {
  LedDrive drive;
  drive.leading = off_by_much(drive.leading);
  Pose2 wrong = drive.leading;
  Outcome outcome;
  for (int i = 0; i < 6 && outcome.verdict != Verdict::kOvertaken; ++i) {
    wrong = wrong * (drive.truth().inverse() * rooms().truth(drive.time + kInterval));
    outcome = drive.go_on();
  }
  ASSERT_EQ(outcome.verdict, Verdict::kOvertaken);
  ASSERT_FALSE(drive.hypotheses.state().others.empty());
  const Hypothesis before = drive.hypotheses.state().others.back();
  EXPECT_LT(distance(before.map_from_base, wrong), 1e-9);
  EXPECT_EQ(outcome.before, before.map_from_base);
  EXPECT_LT(before.log_odds, -drive.options.decisive);
  int scans = 0;
  for (; drive.hypotheses.is_forked() && scans < 20; ++scans) {
    ASSERT_EQ(drive.go_on().verdict, Verdict::kLeads);
    ASSERT_LT(distance(drive.leading, drive.truth()), 0.02);
  }
  EXPECT_LT(scans, 20);
  EXPECT_EQ(drive.hypotheses.state().elsewhere, kNever);
}

TEST(PoseHypotheses, OvertakeARejectedMatchWhenThatIsClear) {
  LedDrive drive;
  drive.seconds = 2.0;
  drive.leading = off_by_much(drive.leading);
  const Outcome outcome = drive.go_on(MatchStatus::kRejectedLowScore);
  ASSERT_EQ(outcome.verdict, Verdict::kOvertaken);
  EXPECT_TRUE(outcome.match.accepted());
  expect_at(outcome.match.map_from_base, drive.truth());
}

/// Odometry was set to a pose that lies too far away to be searched around.
TEST(PoseHypotheses, FollowTheLastMotionWhereOdometryIsImprobable) {
  const auto verdict_with = [](bool is_improbable) {
    LedDrive drive;
    drive.seconds = 2.0;
    drive.leading = shifted(drive.leading, {4.0, 0.0, 0.0});
    const Pose2 by_velocity = shifted(rooms().truth(drive.time + kInterval), {0.02, -0.02, 0.01});
    const Outcome outcome =
        drive.follow(rooms().look(drive.time + kInterval), MatchStatus::kAccepted,
                     is_improbable ? &by_velocity : nullptr);
    if (is_improbable) {
      expect_at(outcome.match.map_from_base, drive.truth());
    }
    return outcome.verdict;
  };
  EXPECT_EQ(verdict_with(true), Verdict::kOvertaken);
  EXPECT_EQ(verdict_with(false), Verdict::kLeads);
}

TEST(PoseHypotheses, HaveOneScanOfARestingRobotSayLessThanOneOfAMovingOne) {
  HypothesisOptions options;
  options.decisive = 20.0;  // so that none decides
  const auto log_odds_after = [&options](double seconds) {
    LedDrive drive;
    drive.options = options;
    drive.time = 0.5;  // at rest
    drive.leading = off_by_much(rooms().truth(0.5));
    drive.seconds = seconds;
    drive.go_on();
    const auto& others = drive.hypotheses.state().others;
    EXPECT_FALSE(others.empty()) << seconds;
    return others.empty() ? 0.0 : others.front().log_odds;
  };
  const double most = log_odds_after(2.0) + kPriorAgainstJump;
  EXPECT_NEAR(most, 12.0, 1e-9) << "of any scan: 6 for one, 6 against the other";
  EXPECT_NEAR(log_odds_after(0.2) + kPriorAgainstJump, 0.1 * most, 1e-6);
  EXPECT_NEAR(log_odds_after(100.0) + kPriorAgainstJump, most, 1e-9);
}

TEST(PoseHypotheses, LeadNowhereWhereScansFitNowhere) {
  // What is seen there is of another building, so nothing in this one explains it.
  const World other_world = make_random_world(8);
  LedDrive drive;
  Outcome outcome;
  int scans = 0;
  for (; outcome.verdict != Verdict::kUnknown && scans < 20; ++scans) {
    outcome = drive.follow(look_around(other_world, laser(), drive.truth(), 5));
  }
  EXPECT_EQ(outcome.verdict, Verdict::kUnknown);
  EXPECT_EQ(scans, 2) << "one that nothing explains is not enough";
  EXPECT_GE(drive.hypotheses.state().elsewhere, drive.options.decisive);
  EXPECT_TRUE(drive.hypotheses.is_in_doubt(drive.options));
}

/// Scans of a robot that odometry has at rest, until it is said to be somewhere unknown.
int scans_until_unknown(const std::function<PointScan(int)>& look, double seconds, int most) {
  LedDrive drive;
  drive.seconds = seconds;
  drive.time = 0.5;
  drive.leading = rooms().truth(0.5);
  for (int i = 0; i < most; ++i) {
    drive.time = 0.5 - kInterval;  // it does not move
    if (drive.follow(look(i), MatchStatus::kRejectedLowScore).verdict == Verdict::kUnknown) {
      return i;
    }
  }
  return most;
}

TEST(PoseHypotheses, SeeWithinSomeScansThatARestingRobotIsCarried) {
  const World other_world = make_random_world(8);
  const RobotMotion other = drive(other_world.route(), {});
  const auto carried = [&](int i) {
    return look_around(other_world, laser(), other.pose(5.0 + 3.0 * i), 5);
  };
  EXPECT_LE(scans_until_unknown(carried, 0.025, 60), 10) << "at 40 scans a second";
  const auto stands = [&](int /*i*/) {
    return look_around(other_world, laser(), other.pose(5.0), 5);
  };
  EXPECT_GT(scans_until_unknown(stands, 0.025, 60), 30) << "the same scan is no new witness";
}

TEST(PoseHypotheses, WhatStandsInTheWayDoesNotCarryTheRobotAway) {
  const auto covered = [](int i) {
    PointScan scan = rooms().look(0.5, static_cast<std::uint64_t>(i));
    for (std::size_t beam = 0; beam < scan.points.size(); ++beam) {
      if ((beam + static_cast<std::size_t>(20 * i)) % 100 < 70) {  // people who walk around it
        scan.points[beam].position *= 0.6 / std::max(1.0, scan.points[beam].position.norm());
      }
    }
    return scan;
  };
  EXPECT_EQ(scans_until_unknown(covered, 0.1, 100), 100);
}

TEST(PoseHypotheses, DoNotDoubtAnythingInUnknownGround) {
  LedDrive drive;
  drive.leading = {500.0, 300.0, 0.0};
  for (int i = 0; i < 40; ++i) {
    const Outcome outcome =
        drive.go_on(i % 2 == 0 ? MatchStatus::kAccepted : MatchStatus::kRejectedLowScore);
    ASSERT_EQ(outcome.verdict, Verdict::kLeads) << i;
    ASSERT_EQ(outcome.evidence.log_odds, 0.0) << i;
    ASSERT_FALSE(drive.hypotheses.is_forked()) << i;
  }
}

TEST(PoseHypotheses, AreBelievedWhereNothingTellsThemApartForLong) {
  LedDrive drive;
  drive.leading = {500.0, 300.0, 0.0};
  drive.hypotheses = PoseHypotheses({Fork{50}, {{{600.0, 300.0, 0.0}, 0.0}}, -9.2});
  double way = 0.0;
  while (drive.hypotheses.is_forked() && drive.time < 60.0) {
    ASSERT_LT(way, 10.0 + 1e-9);
    EXPECT_NEAR(drive.hypotheses.state().fork->undecided, way, 1e-9);
    const Pose2 before = drive.truth();
    ASSERT_EQ(drive.go_on().verdict, Verdict::kLeads);
    way += distance(before, drive.truth());
  }
  EXPECT_FALSE(drive.hypotheses.is_forked());
  EXPECT_GT(way, 10.0);
}

TEST(PoseHypotheses, AJumpThatFitsStandsAndIsWatched) {
  const Rooms& place = rooms();
  const double time = 8.0;
  const PointScan scan = place.look(time);
  const MotionPrediction predicted = prediction(off_by_much(place.truth(time)), {0.2, 0.0, 0.0});
  PoseHypotheses hypotheses;
  const Outcome outcome = hypotheses.follow({scan, place.map(), place.map(), place.keys(),
                                             place.keys(), kInterval, predicted, std::nullopt},
                                            match_at(place.truth(time)), {});
  EXPECT_TRUE(outcome.is_jump);
  EXPECT_EQ(outcome.verdict, Verdict::kLeads);
  EXPECT_EQ(outcome.match.map_from_base, place.truth(time));
  EXPECT_TRUE(hypotheses.is_forked());
  EXPECT_LE(hypotheses.state().elsewhere, 0.0);
  EXPECT_TRUE(hypotheses.is_in_doubt({})) << "the robot may have been carried";
}

TEST(PoseHypotheses, AnUnexpectedMatchThatFitsWorseFollowsTheMotionThatLeads) {
  const Rooms& place = rooms();
  const Pose2 truth = place.truth(8.0);
  const PointScan scan = place.look(8.0);
  MotionPrediction predicted = prediction(truth, {0.2, 0.0, 0.0});
  predicted.covariance *= 0.04;  // by what odometry has shown
  const MatchResult wrong = match_at(off_by_much(truth));
  PoseHypotheses hypotheses;
  const Outcome outcome = hypotheses.follow({scan, place.map(), place.map(), place.keys(),
                                             place.keys(), kInterval, predicted, std::nullopt},
                                            wrong, {});
  EXPECT_EQ(outcome.verdict, Verdict::kLeads);
  EXPECT_EQ(outcome.match.status, MatchStatus::kRejectedUnexpected);
  EXPECT_EQ(outcome.match.map_from_base, truth);
  EXPECT_EQ(outcome.match.covariance, predicted.covariance);
  EXPECT_GT(outcome.evidence.mean, 2.0) << "of where the robot is told to be";
  EXPECT_FALSE(outcome.is_jump);
  EXPECT_FALSE(hypotheses.is_forked()) << "what is refuted at once is none";
}

/// Some six of them, which tell little.
PointScan few_beams(const PointScan& all) {
  PointScan few;
  for (std::size_t beam = 0; beam < all.points.size(); beam += all.points.size() / 6) {
    few.points.push_back(all.points[beam]);
  }
  return few;
}

/// A match that fits a scan better than where the motion leads to, and not by as much as that is
/// likelier by what odometry has shown.
struct UnexpectedMatch {
  Pose2 match = rooms().truth(8.0);
  Pose2 expected = shifted(match, {0.0, 0.11, 0.0});
  PointScan scan = few_beams(rooms().look(8.0));
  PoseHypotheses hypotheses;

  MatchStatus follow(const Pose2& moved) {
    MotionPrediction predicted = prediction(expected, moved);
    predicted.covariance *= 0.04;
    const Outcome outcome = hypotheses.follow({scan, rooms().map(), rooms().map(), rooms().keys(),
                                               rooms().keys(), 0.02, predicted, std::nullopt},
                                              match_at(match), {});
    EXPECT_EQ(outcome.match.map_from_base, expected);
    return outcome.match.status;
  }
};

TEST(PoseHypotheses, AnUnexpectedMatchThatMayBeRightIsAnother) {
  UnexpectedMatch place;
  ASSERT_GT(evidence_between(place.scan, place.match, place.expected, rooms().map()), 3.0);
  ASSERT_EQ(place.follow({0.2, 0.0, 0.0}), MatchStatus::kRejectedUnexpected);
  ASSERT_EQ(place.hypotheses.state().others.size(), 1U);
  EXPECT_EQ(place.hypotheses.state().others.front().map_from_base, place.match);
  EXPECT_LT(place.hypotheses.state().others.front().log_odds, 0.0);
}

TEST(PoseHypotheses, AMatchThatIsRefusedAgainKeepsItsOdds) {
  UnexpectedMatch place;
  const Pose2 at_rest;
  ASSERT_EQ(place.follow(at_rest), MatchStatus::kRejectedUnexpected);
  State state = place.hypotheses.state();
  ASSERT_EQ(state.others.size(), 1U);
  ASSERT_GT(state.others.front().log_odds, -10.0);
  state.others.front().log_odds = -11.0;  // as scans since have it
  place.hypotheses = PoseHypotheses(state);
  ASSERT_EQ(place.follow(at_rest), MatchStatus::kRejectedUnexpected);
  ASSERT_EQ(place.hypotheses.state().others.size(), 1U);
  EXPECT_NEAR(place.hypotheses.state().others.front().log_odds, -11.0, 0.1);
}

TEST(PoseHypotheses, TheKnownPartOfAWallDoesNotDrawAnUnexpectedMatch) {
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  insert_scan(wall_between(-9.0, 0.0), {}, {}, map);
  const PointScan scan = wall_between(-0.6, 9.0);
  MotionPrediction predicted = prediction({0.5, 0.0, 0.0}, {0.3, 0.0, 0.0});
  const Pose2 drawn{-5.0, 0.0, 0.0};
  ASSERT_GT(evidence_of(scan, drawn, map).log_odds, 5.0);
  predicted.covariance = prior_of(1.0, 0.03);
  predicted.search_covariance = prior_of(4.0, 0.03);
  const PlacedScans none;
  PoseHypotheses hypotheses;
  const Outcome outcome = hypotheses.follow(
      {scan, map, map, none, none, kInterval, predicted, std::nullopt}, match_at(drawn), {});
  EXPECT_EQ(outcome.match.status, MatchStatus::kRejectedUnexpected);
  EXPECT_EQ(outcome.match.map_from_base, predicted.fixed_from_base);
}

/// What a robot at a place sees whose odometry caught up, by a scan. It hung at the origin.
void expect_believed(const PointScan& scan, const SlamMap& map, const Pose2& there) {
  const PlacedScans none;
  PoseHypotheses hypotheses;
  const Outcome outcome = hypotheses.follow(
      {scan, map, map, none, none, 0.1, prediction(there, there), prediction({}, {})},
      match_at(there), {});
  EXPECT_EQ(outcome.verdict, Verdict::kLeads);
  EXPECT_EQ(outcome.match.map_from_base, there);
  for (const Hypothesis& other : hypotheses.state().others) {
    EXPECT_GT(other.map_from_base.translation().norm(), 0.5);
  }
}

/// Along a wall no scan tells whether odometry that caught up is right. More of the wall is known
/// where it hung; that says nothing.
TEST(PoseHypotheses, TheKnownPartOfAWallDoesNotSpeakAgainstOdometryThatCatchesUp) {
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  insert_scan(wall_between(-4.0, 4.0), {}, {}, map);
  expect_believed(wall_between(-4.0, 4.0), map, {1.5, 0.0, 0.0});
}

/// A quarter of a metre that fits where odometry hung, of eight metres that fit there and here.
TEST(PoseHypotheses, ALittleThatFitsDoesNotSpeakAgainstOdometryThatCatchesUp) {
  PointScan scan = wall_between(-4.0, 4.0);
  for (double y = 0.7; y < 0.95; y += 0.05) {
    ScanPoint point{{4.2, y}};
    point.normal = {-1.0, 0.0};
    point.weight = 0.05;
    scan.points.push_back(point);
  }
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  insert_scan(scan, {}, {}, map);
  const Pose2 there{1.5, 0.0, 0.0};
  ASSERT_GT(evidence_between(scan, {}, there, map), 0.5);
  expect_believed(scan, map, there);
}

TEST(PoseHypotheses, AfterARefusedMatchAnotherPoseIsSearchedForAtOnce) {
  const Rooms& place = rooms();
  const Pose2 truth = place.truth(8.0);
  HypothesisOptions options;
  options.decisive = 50.0;  // so that none decides
  PoseHypotheses hypotheses;
  const auto follow = [&](const PointScan& scan, const Pose2& predicted, double learned,
                          const MatchResult& match) {
    MotionPrediction motion = prediction(predicted, {});  // odometry tells of no way
    motion.covariance *= learned;
    return hypotheses.follow(
        {scan, place.map(), place.map(), place.keys(), place.keys(), 0.1, motion, std::nullopt},
        match, options);
  };
  const Pose2 wrong = off_by_much(truth);
  const Outcome refused =
      follow(place.look(8.0), {500.0, 0.0, 0.0}, 0.04, match_at({500.3, 0.0, 0.0}));
  ASSERT_EQ(refused.match.status, MatchStatus::kRejectedUnexpected);
  ASSERT_EQ(hypotheses.state().others.size(), 1U);
  follow(place.look(8.0), wrong, 1.0, match_at(wrong));
  ASSERT_FALSE(hypotheses.state().others.empty());
  expect_at(hypotheses.state().others.front().map_from_base, truth);
}

TEST(PoseHypotheses, AMatchIsComparedInTheMapThatItWasMadeIn) {
  // The fork's map knows nothing; what was drawn since does.
  const Rooms& place = rooms();
  const Pose2 truth = place.truth(8.0);
  SlamMap of_fork{MapOptions{}, LikelihoodFieldOptions{}};
  MotionPrediction predicted = prediction(off_by_much(truth), {0.2, 0.0, 0.0});
  predicted.covariance *= 0.04;
  PoseHypotheses hypotheses({Fork{50, 0, 0.0, 0.0}, {{{100.0, 0.0, 0.0}, -5.0}}});
  const Outcome outcome = hypotheses.follow({place.look(8.0), of_fork, place.map(), place.keys(),
                                             place.keys(), kInterval, predicted, std::nullopt},
                                            match_at(truth), {});
  EXPECT_TRUE(outcome.match.accepted());
  EXPECT_EQ(outcome.match.map_from_base, truth);
  EXPECT_EQ(outcome.evidence.log_odds, 0.0) << "in the fork's map";
}

TEST(PoseHypotheses, ARejectedMatchIsNoJump) {
  LedDrive drive;
  const Pose2 far = off_by_much(rooms().truth(8.0));
  const PointScan scan = rooms().look(8.0);
  const MotionPrediction predicted = prediction(rooms().truth(8.0), {0.2, 0.0, 0.0});
  const Outcome outcome =
      drive.hypotheses.follow({scan, rooms().map(), rooms().map(), drive.keys, drive.keys,
                               kInterval, predicted, std::nullopt},
                              match_at(far, MatchStatus::kRejectedLowScore), drive.options);
  EXPECT_FALSE(outcome.is_jump);
}

TEST(PoseHypotheses, AnEmptyScanMovesAllAndTellsNothingOfThem) {
  LedDrive drive;
  drive.hypotheses = PoseHypotheses({Fork{50}, {{{1.0, 2.0, 0.0}, 100.0}}, 100.0});
  const Pose2 moved = drive.truth().inverse() * rooms().truth(drive.time + kInterval);
  const Outcome outcome = drive.follow({}, MatchStatus::kRejectedTooFewPoints);
  EXPECT_EQ(outcome.verdict, Verdict::kLeads);
  EXPECT_EQ(outcome.evidence.log_odds, 0.0);
  const Hypothesis& other = drive.hypotheses.state().others.front();
  EXPECT_LT(distance(other.map_from_base, Pose2{1.0, 2.0, 0.0} * moved), 1e-12);
  EXPECT_EQ(other.log_odds, 100.0);
  EXPECT_EQ(drive.hypotheses.state().elsewhere, 100.0);
}

/// As where nothing is in reach: those that stood still would be somewhere else afterwards.
TEST(PoseHypotheses, GoOnByTheMotionOfAScanThatIsNotWeighed) {
  const Pose2 other{3.0, 1.0, 0.5};
  State before{Fork{50, 0, 1.0, 0.0}, {{other, -1.0}}, -2.0};
  before.profile.fill(3.0F);
  PoseHypotheses hypotheses(before);
  const Pose2 moved{0.3, 0.0, 0.1};
  hypotheses.leave_out(prediction({}, moved).motion);
  hypotheses.leave_out(prediction({}, moved).motion);
  State expected = before;
  expected.others.front().map_from_base = other * moved * moved;
  expected.profile = {};  // what is seen next is compared with none
  expect_same(hypotheses.state(), expected);
}

TEST(PoseHypotheses, DisabledTheyLeaveAllAlone) {
  LedDrive drive;
  drive.options.enabled = false;
  drive.leading = off_by_much(drive.leading);
  for (int i = 0; i < 10; ++i) {
    const Pose2 before = drive.leading;
    const Pose2 moved = drive.truth().inverse() * rooms().truth(drive.time + kInterval);
    const Outcome outcome = drive.go_on();
    ASSERT_EQ(outcome.verdict, Verdict::kLeads);
    ASSERT_EQ(outcome.match.map_from_base, before * moved);
    ASSERT_NE(outcome.evidence.log_odds, 0.0) << "it is told nevertheless";
    expect_same(drive.hypotheses.state(), {});
  }
}

TEST(PoseHypotheses, AreTheLikeliestFew) {
  LedDrive drive;
  drive.options.decisive = 50.0;
  drive.leading = off_by_much(drive.leading);
  State state{Fork{50, 0, 0.0, 1.0}, {}, -9.2};
  for (int i = 0; i < 6; ++i) {  // where nothing is known
    state.others.push_back({{500.0 + 10.0 * i, 0.0, 0.0}, 10.0 - 0.5 * (5 - i)});
  }
  drive.hypotheses = PoseHypotheses(state);
  drive.go_on();
  const std::vector<Hypothesis>& others = drive.hypotheses.state().others;
  ASSERT_EQ(others.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    const Hypothesis& other = others[static_cast<std::size_t>(i)];
    EXPECT_NEAR(other.map_from_base.x, 500.0 + 10.0 * (5 - i), 1.0) << i;
  }
}

TEST(PoseHypotheses, AreSearchedAgainAfterSomeWayOrWhereOdometryIsImprobable) {
  const auto found_with = [](double searched, bool is_improbable) {
    LedDrive drive;
    drive.time = 0.5;  // at rest
    drive.leading = off_by_much(rooms().truth(0.5));
    drive.hypotheses = PoseHypotheses({Fork{50, 0, 0.0, searched}, {}, -5.0});
    const Pose2 by_velocity = drive.truth();
    const Outcome outcome = drive.follow(rooms().look(1.0), MatchStatus::kAccepted,
                                         is_improbable ? &by_velocity : nullptr);
    return outcome.verdict == Verdict::kOvertaken || !drive.hypotheses.state().others.empty();
  };
  EXPECT_FALSE(found_with(0.0, false));
  EXPECT_FALSE(found_with(0.19, false));
  EXPECT_TRUE(found_with(0.21, false));
  EXPECT_TRUE(found_with(0.0, true));
}

TEST(PoseHypotheses, GoOnFromTheirStateAsIfNothingHadBeen) {
  LedDrive drive;
  drive.options.decisive = 6.0;  // so that one scan does not decide
  drive.leading = off_by_much(drive.leading);
  drive.go_on();
  LedDrive restored = drive;
  restored.hypotheses = PoseHypotheses(drive.hypotheses.state());
  expect_same(restored.hypotheses.state(), drive.hypotheses.state());
  bool is_overtaken = false;
  for (int i = 0; i < 8; ++i) {
    const Outcome a = drive.go_on();
    const Outcome b = restored.go_on();
    ASSERT_EQ(a.verdict, b.verdict) << i;
    ASSERT_EQ(a.match.map_from_base, b.match.map_from_base) << i;
    ASSERT_EQ(a.evidence.log_odds, b.evidence.log_odds) << i;
    expect_same(drive.hypotheses.state(), restored.hypotheses.state());
    is_overtaken = is_overtaken || a.verdict == Verdict::kOvertaken;
  }
  EXPECT_TRUE(is_overtaken);
}

TEST(PoseHypotheses, AreInDoubtWhileOddsAreNotDecided) {
  const HypothesisOptions options;
  const auto in_doubt = [&](const std::optional<Fork>& fork, std::vector<Hypothesis> others,
                            double elsewhere) {
    return PoseHypotheses({fork, std::move(others), elsewhere}).is_in_doubt(options);
  };
  EXPECT_FALSE(in_doubt(Fork{}, {}, kNever));
  EXPECT_FALSE(in_doubt(Fork{}, {{{}, -4.7}}, -4.7));
  EXPECT_TRUE(in_doubt(Fork{}, {{{}, -4.5}}, kNever));
  EXPECT_TRUE(in_doubt(Fork{}, {{{}, -9.0}, {{}, -4.5}}, kNever));
  EXPECT_TRUE(in_doubt(Fork{}, {}, -4.5));
  EXPECT_FALSE(in_doubt(std::nullopt, {}, -4.5)) << "nothing else was looked for yet";
  EXPECT_TRUE(PoseHypotheses({Fork{}, {}, kNever}).is_forked());
}

TEST(PoseHypotheses, AreGoneWhereTheLeadingOneIsBelieved) {
  PoseHypotheses hypotheses({Fork{3, 1}, {{{1.0, 0.0, 0.0}, 2.0, {std::nullopt}}}, 1.0});
  ASSERT_TRUE(hypotheses.is_in_doubt({}));
  hypotheses.believe();
  expect_same(hypotheses.state(), {});
  EXPECT_FALSE(hypotheses.is_forked());
}

PlacedScans key_scans_at(const std::vector<Pose2>& poses) {
  PlacedScans keys;
  for (const Pose2& pose : poses) {
    keys.push_back(placed({}, pose));
  }
  return keys;
}

void expect_near(const std::optional<Pose2>& pose, const Pose2& expected) {
  ASSERT_TRUE(pose.has_value());
  EXPECT_LT(difference(*pose, expected).norm(), 1e-12);
}

TEST(PoseHypotheses, NoteWhereEachHasTheKeyScansSinceTheFork) {
  PoseHypotheses hypotheses({Fork{2}, {{{5.0, 1.0, 0.5 * kPi}, 0.0}, {{7.0, 0.0, 0.0}, 0.0}}, -9});
  PlacedScans keys = key_scans_at({{}, {}, {1.0, 0.0, 0.0}, {1.5, 0.0, 0.1}});
  hypotheses.note_key_scans(keys, {1.0, 0.0, 0.0});
  EXPECT_EQ(hypotheses.state().fork->key_scans, 2U);
  EXPECT_EQ(hypotheses.state().fork->inserted, 2U);
  const std::vector<Hypothesis>& others = hypotheses.state().others;
  ASSERT_EQ(others[0].key_scans.size(), 2U);
  ASSERT_EQ(others[1].key_scans.size(), 2U);
  expect_near(others[0].key_scans[0], {5.0, 1.0, 0.5 * kPi});
  expect_near(others[0].key_scans[1], {5.0, 1.5, 0.5 * kPi + 0.1});
  expect_near(others[1].key_scans[1], {7.5, 0.0, 0.1});
  hypotheses.note_key_scans(keys, {1.0, 0.0, 0.0});
  EXPECT_EQ(hypotheses.state().fork->inserted, 2U) << "they were noted already";
  EXPECT_EQ(others[0].key_scans.size(), 2U);
  keys.push_back(placed({}, {2.0, 0.0, 0.0}));
  hypotheses.note_key_scans(keys, {2.0, 0.0, 0.0});
  EXPECT_EQ(hypotheses.state().fork->inserted, 3U);
  ASSERT_EQ(others[0].key_scans.size(), 3U);
  expect_near(others[0].key_scans[2], {5.0, 1.0, 0.5 * kPi});
}

TEST(PoseHypotheses, NoteNoKeyScansWhileThereIsNoFork) {
  PoseHypotheses hypotheses;
  hypotheses.note_key_scans(key_scans_at({{}, {}}), {});
  expect_same(hypotheses.state(), {});
}

TEST(PoseHypotheses, ForgetTheKeyScansSinceTheForkAndNothingElse) {
  PoseHypotheses hypotheses({Fork{1, 0, 3.0, 0.1}, {{{5.0, 1.0, 0.0}, -2.0}}, -9.0});
  const State before = hypotheses.state();
  hypotheses.note_key_scans(key_scans_at({{}, {}, {}}), {});
  ASSERT_EQ(hypotheses.state().fork->inserted, 2U);
  hypotheses.forget_key_scans();
  expect_same(hypotheses.state(), before);
  hypotheses.note_key_scans(key_scans_at({{}, {}}), {});
  EXPECT_EQ(hypotheses.state().fork->inserted, 1U);
  EXPECT_EQ(hypotheses.state().others.front().key_scans.size(), 1U);
}

TEST(PoseHypotheses, ShareTheKeyScansFromBeforeTheyCameUp) {
  LedDrive drive;
  drive.options.decisive = 6.0;  // so that one scan does not decide
  drive.leading = off_by_much(drive.leading);
  const std::size_t mapped = drive.keys.size();
  drive.hypotheses = PoseHypotheses({Fork{mapped, 0, 0.0, 1.0}, {}, -9.2});
  const auto insert = [&](const Pose2& pose) {
    drive.keys.push_back(placed({}, pose));
    drive.hypotheses.note_key_scans(drive.keys, drive.leading);
  };
  insert(drive.leading);
  insert(drive.leading);
  Outcome outcome = drive.go_on();
  ASSERT_EQ(outcome.verdict, Verdict::kLeads);
  ASSERT_FALSE(drive.hypotheses.state().others.empty());
  for (const Hypothesis& other : drive.hypotheses.state().others) {
    EXPECT_EQ(other.key_scans, std::vector<std::optional<Pose2>>(2));
  }
  insert(drive.leading);
  const Pose2 there = drive.truth();
  for (int i = 0; i < 6 && outcome.verdict == Verdict::kLeads; ++i) {
    outcome = drive.go_on();
  }
  ASSERT_EQ(outcome.verdict, Verdict::kOvertaken);
  ASSERT_EQ(outcome.key_scans.size(), 3U);
  EXPECT_FALSE(outcome.key_scans[0].has_value());
  EXPECT_FALSE(outcome.key_scans[1].has_value());
  ASSERT_TRUE(outcome.key_scans[2].has_value());
  expect_at(*outcome.key_scans[2], there);
  // The one that led before has them where they were inserted.
  const Hypothesis& before = drive.hypotheses.state().others.back();
  ASSERT_EQ(before.key_scans.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    expect_near(before.key_scans[i], drive.keys[mapped + i].map_from_base);
  }
}

TEST(PoseHypotheses, SpreadIsZeroAlone) {
  EXPECT_TRUE(PoseHypotheses{}.spread_around({1.0, 2.0, 3.0}).isZero(0.0));
  EXPECT_TRUE(PoseHypotheses({Fork{}, {}, 0.0}).spread_around({1.0, 2.0, 3.0}).isZero(0.0));
}

TEST(PoseHypotheses, SpreadCoversTheOtherPoseWhereItsOddsAreEven) {
  const Pose2 leading{1.0, 2.0, 3.0};
  const Eigen::Vector3d apart(0.6, -0.8, 0.4);
  const PoseHypotheses hypotheses({Fork{}, {{displaced(leading, apart), 0.0}}, -9.0});
  const Eigen::Matrix3d spread = hypotheses.spread_around(leading);
  EXPECT_TRUE(spread.isApprox(0.5 * apart * apart.transpose(), 1e-9));
  EXPECT_LT(apart.head<2>().norm(), 2.0 * std::sqrt(spread(0, 0) + spread(1, 1)));
}

TEST(PoseHypotheses, SpreadIsLessTheLessTheOthersAreLikely) {
  const auto spread = [](double log_odds) {
    return PoseHypotheses({Fork{}, {{{1.0, 0.0, 0.0}, log_odds}}, -9.0}).spread_around({})(0, 0);
  };
  EXPECT_NEAR(spread(-std::log(99.0)), 0.01, 1e-9);
  EXPECT_NEAR(spread(std::log(3.0)), 0.75, 1e-9);
  EXPECT_LT(spread(-9.0), 2e-4);
  EXPECT_LE(spread(1e6), 1.0) << "and a number";
  EXPECT_GT(spread(1e6), 0.99);
}

TEST(PoseHypotheses, SpreadIsOfAllOthers) {
  const PoseHypotheses hypotheses({Fork{}, {{{1.0, 0.0, 0.0}, 0.0}, {{0.0, 2.0, 0.0}, 0.0}}, -9.0});
  const Eigen::Matrix3d expected = Eigen::Vector3d(1.0 / 3.0, 4.0 / 3.0, 0.0).asDiagonal();
  EXPECT_TRUE(hypotheses.spread_around({}).isApprox(expected, 1e-12));
}

}  // namespace
}  // namespace matchbox_slam
