#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/matching/contradiction.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "slam/likeliest_match.hpp"
#include "slam/pose_distance.hpp"

namespace matchbox_slam {
namespace {

/// Answers by a function of the prediction, and remembers what it was asked.
class AskedMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    asked.push_back(problem.predicted_map_from_base);
    covariances.push_back(problem.prior_covariance);
    return answers.at(asked.size() - 1);
  }

  std::vector<MatchResult> answers;
  mutable std::vector<Pose2> asked;
  mutable std::vector<Eigen::Matrix3d> covariances;
};

MatchResult answer(const Pose2& map_from_base, double score) {
  MatchResult result;
  result.map_from_base = map_from_base;
  result.covariance = prior_of(0.01, 0.01);
  result.score = score;
  result.status = MatchStatus::kAccepted;
  result.candidates = 10;
  return result;
}

MotionPrediction prediction(const Pose2& map_from_base, double way, bool is_by_odometry) {
  MotionPrediction predicted;
  predicted.fixed_from_base = map_from_base;
  predicted.covariance = prior_of(0.03, 0.03);
  predicted.motion.previous_from_current = {way, 0.0, 0.0};
  predicted.motion.is_by_odometry = is_by_odometry;
  return predicted;
}

/// Of every ten beams so many end where they did.
PointScan partly_hidden(PointScan scan, double fits) {
  constexpr double kBefore = 0.8;  // of the way to the wall
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    if (static_cast<double>(i % 10) >= 10.0 * fits) {
      scan.points[i].position *= kBefore;
    }
  }
  return scan;
}

// --- what there is to match ---

TEST(LikeliestMatch, WhereThereIsNothingToMatchTheMatcherIsNotAsked) {
  const MatchScene scene = make_match_scene(make_rooms_world(4), LaserOptions{}, 30.0, 3);
  const SlamMap empty{MapOptions{}, LikelihoodFieldOptions{}};
  PointScan few = scene.scan;
  few.points.resize(9);
  const AskedMatcher matcher;
  MotionPrediction predicted = prediction(scene.map_from_base, 0.1, true);
  const auto status_of = [&](const PointScan& scan, const SlamMap& map) {
    const WeighedMatch weighed =
        match_likeliest(matcher, {scan, map, scene.key_scans, 1, {}}, {}, predicted, {});
    EXPECT_EQ(weighed.match.map_from_base, predicted.fixed_from_base);
    EXPECT_EQ(weighed.match.covariance, predicted.covariance);
    return weighed.match.status;
  };
  EXPECT_EQ(status_of(scene.scan, empty), MatchStatus::kRejectedNoReference);
  EXPECT_EQ(status_of(few, empty), MatchStatus::kRejectedNoReference);
  EXPECT_EQ(status_of(few, scene.map), MatchStatus::kRejectedTooFewPoints);
  EXPECT_TRUE(matcher.asked.empty());
}

TEST(LikeliestMatch, AsManyPointsAsTheOptionsAskForAreMatched) {
  const MatchScene scene = make_match_scene(make_rooms_world(4), LaserOptions{}, 30.0, 3);
  PointScan few = scene.scan;
  few.points.resize(10);
  AskedMatcher matcher;
  matcher.answers = {answer(scene.map_from_base, 0.9)};
  MotionPrediction predicted = prediction(scene.map_from_base, 0.1, true);
  const WeighedMatch weighed =
      match_likeliest(matcher, {few, scene.map, scene.key_scans, 1, {}}, {}, predicted, {});
  EXPECT_TRUE(weighed.match.accepted());
  EXPECT_EQ(matcher.asked.size(), 1U);
}

// --- a map that was drawn wrong ---

/// A scan of a robot whose map is wrong everywhere: each wall was drawn too near.
class DrawnWrongTest : public testing::Test {
 protected:
  DrawnWrongTest() {
    for (const PlacedScan& key : scene_.key_scans) {
      insert_scan(partly_hidden(*key.scan->points(), 0.0), key.map_from_base, MapOptions{}, wrong_);
    }
  }

  /// What was seen 0.3 m from the scan, placed off by this.
  [[nodiscard]] PlacedScan newest(const Eigen::Vector3d& off) const {
    const Pose2 before = shifted(scene_.map_from_base, {-0.3, 0.0, 0.1});
    return placed(look_around(world_, LaserOptions{}, before, 5), shifted(before, off));
  }

  /// How a scan is asked for whose pose the map contradicts.
  struct Asked {
    bool is_by_odometry = true;
    bool may_map_be_wrong = true;
    Expectation expected = {0.9, false, 0.9};
    Eigen::Vector3d off = {0.03, 0.02, 0.01};  ///< what odometry predicts, seen from the truth
    bool is_odometry_improbable = false;
  };

  [[nodiscard]] WeighedMatch match(const PlacedScans& recent, const Asked& asked) const {
    AskedMatcher matcher;
    matcher.answers = {2, answer(scene_.map_from_base, 0.05)};
    MotionPrediction predicted =
        prediction(shifted(scene_.map_from_base, asked.off), 0.1, asked.is_by_odometry);
    predicted.covariance = prior_of(0.1, 0.03);
    const ScanToMatch scan{scene_.scan, wrong_, recent, 1, asked.expected, asked.may_map_be_wrong};
    std::optional<SteadyPrediction> steady;
    if (asked.is_odometry_improbable) {
      steady = SteadyPrediction{prediction(scene_.map_from_base, 0.1, false), true};
    }
    return match_likeliest(matcher, scan, steady, predicted, {});
  }
  [[nodiscard]] WeighedMatch match(const PlacedScans& recent) const { return match(recent, {}); }

  World world_ = make_rooms_world(4);
  MatchScene scene_ = make_match_scene(world_, LaserOptions{}, 30.0, 3);
  SlamMap wrong_{MapOptions{}, LikelihoodFieldOptions{}};
};

TEST_F(DrawnWrongTest, WhatFitsTheNewestKeyScansIsBelieved) {
  const WeighedMatch believed = match({newest({0.0, 0.0, 0.0})});
  EXPECT_TRUE(believed.match.accepted());
  EXPECT_EQ(believed.certainty, Certainty::kSure);
  EXPECT_FALSE(believed.jumped);
  EXPECT_LT(distance(believed.match.map_from_base, scene_.map_from_base), 0.01);
  EXPECT_NEAR(believed.match.map_from_base.theta, scene_.map_from_base.theta, 0.002);
}

/// The points of a key scan that lie to that side of it.
PlacedScan half_of(const PlacedScan& key, bool is_left) {
  PointScan points = *key.scan->points();
  points.points.erase(
      std::remove_if(points.points.begin(), points.points.end(),
                     [&](const ScanPoint& point) { return (point.position.y() > 0.0) != is_left; }),
      points.points.end());
  return placed(std::move(points), key.map_from_base);
}

TEST_F(DrawnWrongTest, OlderKeyScansThatWereDrawnWrongAreNotAsked) {
  const PlacedScan right = newest({0.0, 0.0, 0.0});
  const PlacedScan seen_last = half_of(right, true);
  // Walls before those that the scan sees to the other side: it would look through them.
  const PlacedScan other = half_of(right, false);
  const PlacedScan wrong = placed(partly_hidden(*other.scan->points(), 0.0), other.map_from_base);
  EXPECT_TRUE(match({wrong, wrong, wrong, seen_last, seen_last}).match.accepted());
  EXPECT_FALSE(match({seen_last, wrong, wrong}).match.accepted());
}

TEST_F(DrawnWrongTest, WithoutKeyScansThatFitThePoseStaysDoubtful) {
  EXPECT_EQ(match({}).certainty, Certainty::kDoubtful);
  EXPECT_EQ(match({newest({0.0, 0.0, 0.5})}).certainty, Certainty::kDoubtful);
}

TEST_F(DrawnWrongTest, ThePoseStaysDoubtfulWhereItMayBeWhatIsWrong) {
  const PlacedScans recent{newest({0.0, 0.0, 0.0})};
  const auto certainty = [&](const Asked& asked) { return match(recent, asked).certainty; };
  EXPECT_EQ(certainty({}), Certainty::kSure);
  EXPECT_EQ(certainty({false}), Certainty::kDoubtful) << "without odometry";
  EXPECT_EQ(certainty({true, false}), Certainty::kDoubtful) << "where loops move no map";
  EXPECT_EQ(certainty({true, true, {0.9, true}}), Certainty::kDoubtful) << "in doubt";
  EXPECT_EQ(certainty({true, true, {0.9, false, 1.0}}), Certainty::kDoubtful)
      << "after a metre that the map contradicts";
  Asked improbable;
  improbable.is_odometry_improbable = true;
  EXPECT_EQ(certainty(improbable), Certainty::kDoubtful) << "by odometry that cannot be";
}

TEST_F(DrawnWrongTest, TheMapsContradictionIsTold) {
  const WeighedMatch believed = match({newest({0.0, 0.0, 0.0})});
  EXPECT_TRUE(believed.overruled);
  const Pose2& pose = believed.match.map_from_base;
  const double on_backs = share_on_backs(scene_.scan, pose, wrong_.occupancy, wrong_.field);
  EXPECT_GT(believed.match.contradiction, 0.1);
  EXPECT_DOUBLE_EQ(believed.match.contradiction,
                   contradiction(scene_.scan, pose, wrong_.field) + 2.0 * on_backs);
}

TEST_F(DrawnWrongTest, FarFromWhereOdometryHasItItIsAJump) {
  Asked far;
  far.off = {0.19, 0.0, 0.0};
  const WeighedMatch near = match({newest({0.0, 0.0, 0.0})}, far);
  EXPECT_TRUE(near.overruled) << to_string(near.certainty);
  EXPECT_FALSE(near.jumped) << distance(near.match.map_from_base, scene_.map_from_base);
  far.off = {0.21, 0.0, 0.0};
  const WeighedMatch jump = match({newest({0.0, 0.0, 0.0})}, far);
  EXPECT_TRUE(jump.overruled);
  EXPECT_TRUE(jump.jumped);
}

TEST_F(DrawnWrongTest, WhatFitsLessThanIsUsualIsNotBelieved) {
  const PlacedScans recent{newest({0.0, 0.0, 0.0})};
  const PointScan whole = scene_.scan;
  scene_.scan = partly_hidden(whole, 0.8);
  EXPECT_EQ(match(recent).certainty, Certainty::kSure);
  scene_.scan = partly_hidden(whole, 0.6);
  EXPECT_EQ(match(recent).certainty, Certainty::kDoubtful);
}

// --- whether the robot would have been carried ---

/// A match that is right, of half of the usual score: a second look finds nothing better. Odometry
/// has the robot elsewhere.
struct Doubtful {
  Eigen::Vector3d off;  ///< what odometry predicts, seen from the truth [m], [rad]
  double way = 0.0;     ///< [m] since the scan before, by odometry
  bool is_by_odometry = true;
  double usual_score = 0.9;
  bool is_in_doubt = false;
  double fits = 1.0;  ///< share of the scan, for the rest something stands before the walls
};

WeighedMatch weighed(const Doubtful& doubtful, const MatchScene& scene) {
  AskedMatcher matcher;
  matcher.answers = {answer(scene.map_from_base, 0.45)};
  MotionPrediction predicted =
      prediction(shifted(scene.map_from_base, doubtful.off), doubtful.way, doubtful.is_by_odometry);
  const PointScan hidden = partly_hidden(scene.scan, doubtful.fits);
  const ScanToMatch scan{
      hidden, scene.map, scene.key_scans, 1, {doubtful.usual_score, doubtful.is_in_doubt}};
  return match_likeliest(matcher, scan, {}, predicted, {});
}

/// The same place in a map whose frame is another one.
MatchScene seen_from(const MatchScene& scene, const Pose2& map_from_frame) {
  MatchScene moved;
  for (const PlacedScan& key : scene.key_scans) {
    moved.key_scans.push_back({key.scan, map_from_frame * key.map_from_base});
    insert_scan(*key.scan->points(), moved.key_scans.back().map_from_base, MapOptions{}, moved.map);
  }
  moved.scan = scene.scan;
  moved.map_from_base = map_from_frame * scene.map_from_base;
  return moved;
}

class CarriedTest : public testing::Test {
 protected:
  [[nodiscard]] bool is_jump(const Doubtful& doubtful) const {
    const WeighedMatch match = weighed(doubtful, scene_);
    EXPECT_TRUE(match.match.accepted());
    EXPECT_EQ(match.match.map_from_base, scene_.map_from_base);
    return match.jumped;
  }

  MatchScene scene_ = make_match_scene(make_rooms_world(4), LaserOptions{}, 30.0, 3);
};

TEST_F(CarriedTest, ADoubtfulMatchFarFromWhereOdometryHasItIsAJump) {
  EXPECT_TRUE(weighed({{0.25, 0.0, 0.0}}, scene_).upheld) << "what this is about";
  for (const double direction : {0.0, 0.8, 1.6, 3.0, -2.0}) {
    const Eigen::Vector3d ahead(std::cos(direction), std::sin(direction), 0.0);
    EXPECT_FALSE(is_jump({0.19 * ahead})) << direction;
    EXPECT_TRUE(is_jump({0.21 * ahead})) << direction;
  }
}

TEST_F(CarriedTest, HalfOfTheWayMayBeWrong) {
  EXPECT_TRUE(is_jump({{0.21, 0.0, 0.0}, 0.38}));
  EXPECT_FALSE(is_jump({{0.21, 0.0, 0.0}, 0.44}));
  EXPECT_FALSE(is_jump({{0.0, -0.39, 0.0}, 0.8}));
  EXPECT_TRUE(is_jump({{0.0, -0.41, 0.0}, 0.8}));
  EXPECT_FALSE(is_jump({{0.0, -0.41, 0.0}, -0.84})) << "backwards, too";
}

TEST_F(CarriedTest, ATurnIsNone) { EXPECT_FALSE(is_jump({{0.0, 0.0, 0.4}})); }

TEST_F(CarriedTest, WithoutOdometryNothingIsAJump) {
  EXPECT_FALSE(is_jump({{0.25, 0.0, 0.0}, 0.0, false}));
  EXPECT_FALSE(is_jump({{0.45, 0.0, 0.0}, 0.0, false}));
}

TEST_F(CarriedTest, AMatchThatNothingSpeaksAgainstIsNone) {
  EXPECT_FALSE(is_jump({{0.45, 0.0, 0.0}, 0.0, true, 0.45}));
}

TEST_F(CarriedTest, InDoubtItIsOneFarFromThePlaceBefore) {
  EXPECT_FALSE(is_jump({{0.19, 0.0, 0.0}, 0.0, true, 0.45, true}));
  EXPECT_TRUE(is_jump({{0.21, 0.0, 0.0}, 0.0, true, 0.45, true}));
  EXPECT_FALSE(is_jump({{0.21, 0.0, 0.0}, 0.44, true, 0.45, true}));
  EXPECT_FALSE(is_jump({{0.25, 0.0, 0.0}, 0.0, false, 0.45, true}));
}

TEST_F(CarriedTest, OneThatHardlyFitsIsWhereverOdometryDoesNotHaveIt) {
  const auto is_jump_of = [this](double fits, double off, bool is_by_odometry = true) {
    Doubtful doubtful{{0.0, off, 0.0}, 0.0, is_by_odometry};
    doubtful.fits = fits;
    return is_jump(doubtful);
  };
  EXPECT_TRUE(is_jump_of(0.3, 0.06));
  EXPECT_TRUE(is_jump_of(0.3, 0.15));
  EXPECT_FALSE(is_jump_of(0.3, 0.04)) << "odometry speaks for it";
  EXPECT_FALSE(is_jump_of(0.7, 0.15));
  EXPECT_FALSE(is_jump_of(0.3, 0.15, false));
  Doubtful in_doubt{{0.0, 0.15, 0.0}, 0.0, true, 0.9, true};
  in_doubt.fits = 0.3;
  EXPECT_FALSE(is_jump(in_doubt)) << "it begins no provisional pose anew";
  Doubtful on_the_way{{0.0, 0.15, 0.0}, 0.4};
  on_the_way.fits = 0.3;
  EXPECT_FALSE(is_jump(on_the_way)) << "half of the way may be wrong";
}

TEST_F(CarriedTest, TheMapsFrameDoesNotMatter) {
  const MatchScene moved = seen_from(scene_, {37.3, -21.8, 0.8});
  for (const double off : {0.19, 0.21}) {
    const WeighedMatch match = weighed({{off, 0.0, 0.0}}, moved);
    EXPECT_TRUE(match.upheld);
    EXPECT_EQ(match.jumped, off > 0.2);
  }
}

// --- odometry that tells of a step that cannot be ---

const Pose2 kByOdometry{0.5, 0.0, 0.0};
const Pose2 kSteadily{0.1, 0.0, 0.0};

/// A wall so far away that no beam crosses it: a match is worth its score, to the bit.
class SteadyTest : public testing::Test {
 protected:
  SteadyTest() {
    map_.field.update({{{50.0, 0.0}, {-1.0, 0.0}}}, {});
    for (int i = 0; i < 20; ++i) {
      scan_.points.push_back({{1.0, 0.1 * i}, {0.0, 0.0}, {-1.0, 0.0}, 0.1, false});
    }
    options_.doubt.enabled = false;  // no second looks
  }

  /// Whether the prediction by a steady motion wins with these answers.
  bool is_steady(const MatchResult& by_odometry, const MatchResult& steadily) {
    AskedMatcher matcher;
    matcher.answers = {by_odometry, steadily};
    MotionPrediction predicted = prediction(kByOdometry, 0.5, true);
    MotionPrediction steady = prediction(kSteadily, 0.1, false);
    steady.covariance = prior_of(0.2, 0.1);
    const WeighedMatch weighed = match_likeliest(
        matcher, {scan_, map_, {}, 1, {}}, SteadyPrediction{steady, true}, predicted, options_);
    EXPECT_EQ(matcher.asked, (std::vector<Pose2>{kByOdometry, kSteadily}));
    EXPECT_EQ(matcher.covariances.at(0), prior_of(0.03, 0.03));
    EXPECT_EQ(matcher.covariances.at(1), prior_of(0.2, 0.1));
    const bool is_steady = predicted.fixed_from_base == kSteadily;
    EXPECT_EQ(predicted.motion.is_by_odometry, !is_steady);
    const MatchResult& expected = is_steady ? steadily : by_odometry;
    EXPECT_EQ(weighed.match.map_from_base, expected.map_from_base);
    EXPECT_EQ(weighed.match.score, expected.score);
    return is_steady;
  }

  static MatchResult refused() {
    MatchResult result = answer(kByOdometry, 0.4);  // of what the matcher asks for more
    result.status = MatchStatus::kRejectedLowScore;
    return result;
  }

  SlamMap map_{MapOptions{}, LikelihoodFieldOptions{}};
  PointScan scan_;
  EngineOptions options_;
};

TEST_F(SteadyTest, WinsWhereItIsClearlyLikelier) {
  EXPECT_TRUE(is_steady(answer(kByOdometry, 0.5), answer(kSteadily, 0.61)));
  EXPECT_FALSE(is_steady(answer(kByOdometry, 0.5), answer(kSteadily, 0.59)));
  EXPECT_FALSE(is_steady(answer(kByOdometry, 0.9), answer(kSteadily, 0.5)));
}

TEST_F(SteadyTest, WinsWhereOdometryFindsNothing) {
  EXPECT_TRUE(is_steady(refused(), answer(kSteadily, 0.41)));
}

TEST_F(SteadyTest, HasToConvinceByItself) {
  EXPECT_FALSE(is_steady(refused(), answer(kSteadily, 0.39)));
  MatchResult steadily = answer(kSteadily, 0.9);
  steadily.rival_share = 0.95;
  EXPECT_FALSE(is_steady(answer(kByOdometry, 0.5), steadily)) << "another place fits as well";
  steadily.rival_share = 0.0;
  steadily.status = MatchStatus::kRejectedLowScore;
  EXPECT_FALSE(is_steady(answer(kByOdometry, 0.5), steadily));
  steadily.status = MatchStatus::kAccepted;
  EXPECT_TRUE(is_steady(answer(kByOdometry, 0.5), steadily));
}

/// Through the wall that is 0.4 m ahead the beams go by a steady motion, and not by odometry.
TEST_F(SteadyTest, WhatSpeaksAgainstAMatchCountsAsMuchAsItsScore) {
  std::vector<SurfaceHit> wall;
  for (double y = -3.0; y < 5.0; y += 0.02) {
    wall.push_back({{0.6, y}, {-1.0, 0.0}});
  }
  map_.field.update(wall, {});
  options_.doubt.contradiction = 1.0;
  AskedMatcher matcher;
  matcher.answers = {answer({-0.4, 0.0, 0.0}, 0.5), answer({0.0, 0.0, 0.0}, 0.9)};
  MotionPrediction predicted = prediction(kByOdometry, 0.5, true);
  const WeighedMatch weighed = match_likeliest(
      matcher, {scan_, map_, {}, 1, {}}, SteadyPrediction{prediction(kSteadily, 0.1, false), true},
      predicted, options_);
  EXPECT_EQ(weighed.match.score, 0.5);
  EXPECT_LT(weighed.match.contradiction, 0.01);
  EXPECT_EQ(predicted.fixed_from_base, kByOdometry);
}

// --- odometry that tells of another step than the last motion does ---

/// A robot that goes on as it did, while odometry may have it turned.
class AnotherStepTest : public testing::Test {
 protected:
  struct Step {
    double turned;                       ///< [rad] by which odometry is off
    Eigen::Vector3d steady = {0, 0, 0};  ///< by which the last motion is [m], [rad]
    double score_steadily = 0.9;         ///< of a match where it is
  };

  /// Whether the last motion was asked, and won.
  struct Asked {
    bool is_asked;
    bool has_won;
  };

  [[nodiscard]] Asked match(const Step& step) const {
    const Pose2& truth = scene_.map_from_base;
    const Pose2 by_odometry = shifted(truth, {0.0, 0.0, step.turned});
    const Pose2 steadily = shifted(truth, step.steady);
    AskedMatcher matcher;
    matcher.answers = {answer(by_odometry, 0.05), answer(truth, step.score_steadily)};
    MotionPrediction predicted = prediction(by_odometry, 0.2, true);
    EngineOptions options;
    options.doubt.look_theta = 0.1;  // so that no second look finds it
    const WeighedMatch weighed =
        match_likeliest(matcher, {scene_.scan, scene_.map, scene_.key_scans, 1, {0.9, false}},
                        SteadyPrediction{prediction(steadily, 0.2, false)}, predicted, options);
    const bool has_won = predicted.fixed_from_base == steadily;
    EXPECT_EQ(has_won, weighed.match.accepted() && weighed.certainty == Certainty::kSure);
    return {matcher.asked.size() == 2, has_won};
  }

  MatchScene scene_ = make_match_scene(make_rooms_world(4), LaserOptions{}, 30.0, 3);
};

TEST_F(AnotherStepTest, TheRobotMayHaveGoneOnWhereOdometryLeadsIntoDoubt) {
  EXPECT_TRUE(match({1.0}).has_won);
  EXPECT_FALSE(match({1.0, {0.0, 0.0, 0.0}, 0.3}).has_won) << "that has to convince";
}

TEST_F(AnotherStepTest, TheLastMotionIsNotAskedWhereItSaysTheSame) {
  EXPECT_FALSE(match({0.6, {0.19, 0.0, 0.6}}).is_asked);
  EXPECT_TRUE(match({0.6, {0.21, 0.0, 0.6}}).is_asked);
  EXPECT_FALSE(match({0.6, {0.0, 0.0, 0.51}}).is_asked);
  EXPECT_TRUE(match({0.6, {0.0, 0.0, 0.49}}).is_asked);
}

/// A second look finds it too, and would have to be confirmed.
TEST_F(AnotherStepTest, AFarTurnOfASecondLookHasToBeClearlyBetter) {
  const Pose2& truth = scene_.map_from_base;
  const auto match = [&](double turned, double score_steadily,
                         const std::optional<SteadyPrediction>& steady) {
    const Pose2 by_odometry = shifted(truth, {0.0, 0.0, turned});
    AskedMatcher matcher;
    matcher.answers = {answer(by_odometry, 0.05), answer(truth, score_steadily)};
    MotionPrediction predicted = prediction(by_odometry, 0.2, true);
    return match_likeliest(matcher, {scene_.scan, scene_.map, scene_.key_scans, 1, {0.9, false}},
                           steady, predicted, {});
  };
  const WeighedMatch second_look = match(0.51, 0.0, {});
  ASSERT_TRUE(second_look.jumped);
  const double net = net_score(second_look.match);
  const SteadyPrediction steady{prediction(truth, 0.2, false)};
  EXPECT_FALSE(match(0.51, net - 0.09, steady).jumped);
  EXPECT_TRUE(match(0.51, net - 0.11, steady).jumped);
  EXPECT_TRUE(match(0.49, net, steady).jumped) << "no far turn";
}

TEST_F(AnotherStepTest, OfTwoFarTurnsThatFitAsWellOdometrysStands) {
  const Pose2& truth = scene_.map_from_base;
  AskedMatcher matcher;
  matcher.answers = {2, answer(shifted(truth, {1.0, 1.0, 1.0}), 0.05)};
  MotionPrediction predicted = prediction(shifted(truth, {0.0, 0.0, 0.51}), 0.2, true);
  const SteadyPrediction steady{prediction(shifted(truth, {0.0, 0.0, -0.51}), 0.2, false)};
  const WeighedMatch weighed = match_likeliest(
      matcher, {scene_.scan, scene_.map, scene_.key_scans, 1, {0.9, false}}, steady, predicted, {});
  EXPECT_EQ(matcher.asked.size(), 2U);
  EXPECT_TRUE(weighed.jumped);
  EXPECT_TRUE(predicted.motion.is_by_odometry);
}

TEST_F(AnotherStepTest, TheLastMotionIsNotAskedWhereOdometryLeadsToAPlaceThatFits) {
  AskedMatcher matcher;
  matcher.answers = {answer(scene_.map_from_base, 0.9)};
  MotionPrediction predicted = prediction(scene_.map_from_base, 0.2, true);
  const SteadyPrediction steady{
      prediction(shifted(scene_.map_from_base, {0.5, 0.0, 0.3}), 0.2, false)};
  const WeighedMatch weighed = match_likeliest(
      matcher, {scene_.scan, scene_.map, scene_.key_scans, 1, {0.9, false}}, steady, predicted, {});
  EXPECT_EQ(weighed.certainty, Certainty::kSure);
  EXPECT_EQ(matcher.asked.size(), 1U);
  EXPECT_TRUE(predicted.motion.is_by_odometry);
}

}  // namespace
}  // namespace matchbox_slam
