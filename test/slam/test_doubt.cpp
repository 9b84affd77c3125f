#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/slam/doubt.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "slam/pose_distance.hpp"

namespace matchbox_slam {
namespace {

MatchScene scene_in_rooms(double time) {
  return make_match_scene(make_rooms_world(4), LaserOptions{}, time, 3);
}

/// Answers as it is told, whatever the problem.
class ToldMatcher : public ScanMatcher {
 public:
  explicit ToldMatcher(MatchResult answer) : answer_(std::move(answer)) {}
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& /*problem*/) const override {
    return answer_;
  }

 private:
  MatchResult answer_;
};

MatchResult answer(const Pose2& map_from_base, double score, MatchStatus status) {
  MatchResult result;
  result.map_from_base = map_from_base;
  result.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  result.score = score;
  result.status = status;
  result.candidates = 10;
  return result;
}

TEST(Doubt, AGoodMatchIsSureAndAsTheMatcherFoundIt) {
  const MatchScene scene = scene_in_rooms(30.0);
  const MatchProblem problem =
      scene.problem(shifted(scene.map_from_base, {0.03, -0.02, 0.01}), prior_of(0.05, 0.02));
  const OlsonMatcher olson;
  const WeighedMatch weighed =
      match_and_weigh(olson, problem, scene.map.occupancy, {0.0, false}, {});
  EXPECT_EQ(weighed.certainty, Certainty::kSure);
  EXPECT_EQ(weighed.match.map_from_base, olson.match(problem).map_from_base);
  EXPECT_LT(weighed.match.contradiction, 0.01);
}

TEST(Doubt, ATurnThatOdometryMissedIsFoundByASecondLook) {
  // Odometry is off by 0.9 rad and 0.4 m and sure of 0.03 rad and 3 cm. Where a room is alike after
  // a quarter of a turn, at 160 s and 180 s, one scan cannot tell.
  for (double time = 20.0; time < 150.0; time += 20.0) {
    const MatchScene scene = scene_in_rooms(time);
    const MatchProblem problem =
        scene.problem(shifted(scene.map_from_base, {0.3, -0.25, 0.9}), prior_of(0.03, 0.03));
    const WeighedMatch weighed =
        match_and_weigh(OlsonMatcher{}, problem, scene.map.occupancy, {0.0, false}, {});
    EXPECT_EQ(weighed.certainty, Certainty::kSecondLook) << time;
    EXPECT_LT(distance(weighed.match.map_from_base, scene.map_from_base), 0.01) << time;
    EXPECT_LT(std::abs(wrap_angle(weighed.match.map_from_base.theta - scene.map_from_base.theta)),
              0.002)
        << time;
  }
}

/// Where two corridors of 30 m cross, with a cupboard in one of four arms that else are alike.
World crossing() {
  std::vector<WallSegment> walls;
  for (const double turn : {0.0, 0.5, 1.0, 1.5}) {
    const Eigen::Rotation2Dd arm(turn * kPi);
    const auto add = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
      walls.push_back({arm * from, arm * to});
    };
    add({1.0, 1.0}, {15.0, 1.0});
    add({1.0, -1.0}, {15.0, -1.0});
    add({15.0, -1.0}, {15.0, 1.0});
    if (turn == 0.0) {
      add({2.0, 1.0}, {2.0, 0.8});
      add({2.0, 0.8}, {4.0, 0.8});
      add({4.0, 0.8}, {4.0, 1.0});
    }
  }
  return {walls, {}};
}

/// After a quarter of a turn a crossing is alike, and here the search's lattice holds that pose,
/// while the true one lies half a step from its nearest pose in x, y and heading.
TEST(Doubt, AtACrossingTheTurnIsFoundThatThePredictionSpeaksFor) {
  const World world = crossing();
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  std::uint64_t seed = 0;
  for (double along = -10.0; along <= 10.0; along += 2.0) {
    for (const Pose2& pose : {Pose2{along, 0.0, 0.0}, Pose2{along, 0.0, kPi},
                              Pose2{0.0, along, 0.5 * kPi}, Pose2{0.0, along, -0.5 * kPi}}) {
      insert_scan(look_around(world, LaserOptions{}, pose, ++seed), pose, MapOptions{}, map);
    }
  }
  DoubtOptions options;
  options.most_rival = 1.0;
  for (double turned = 0.23; turned < 0.4; turned += 0.02) {
    const Pose2 truth{0.225, 0.0, 0.7};  // turned about the crossing's middle: 0, 0.225
    const PointScan scan = look_around(world, LaserOptions{}, truth, ++seed);
    const Pose2 predicted = shifted(truth, {0.025, 0.025, turned});
    const ToldMatcher matcher(answer(predicted, 0.05, MatchStatus::kRejectedLowScore));
    const WeighedMatch weighed =
        match_and_weigh(matcher, {scan, predicted, prior_of(0.08, 0.09), map.field, {}, 1},
                        map.occupancy, {0.9, false}, options);
    EXPECT_EQ(weighed.certainty, Certainty::kSecondLook) << turned;
    EXPECT_LT(std::abs(weighed.match.map_from_base.theta - truth.theta), 0.002) << turned;
  }
}

TEST(Doubt, TurnedOffEveryMatchIsBelieved) {
  const MatchScene scene = scene_in_rooms(30.0);
  const MatchProblem problem =
      scene.problem(shifted(scene.map_from_base, {0.3, -0.25, 0.9}), prior_of(0.03, 0.03));
  DoubtOptions options;
  options.enabled = false;
  EXPECT_EQ(match_and_weigh(OlsonMatcher{}, problem, scene.map.occupancy, {0.0, false}, options)
                .certainty,
            Certainty::kSure);
}

TEST(Doubt, AMatchThroughWallsIsRejectedWithACovarianceThatCoversTheLook) {
  const MatchScene scene = scene_in_rooms(30.0);
  const Pose2 wrong = shifted(scene.map_from_base, {2.5, -2.0, 2.5});  // out of sight of a look
  const ToldMatcher matcher(answer(wrong, 0.3, MatchStatus::kAccepted));
  const MatchProblem problem = scene.problem(wrong, prior_of(0.03, 0.03));
  const WeighedMatch weighed =
      match_and_weigh(matcher, problem, scene.map.occupancy, {0.0, false}, {});
  EXPECT_EQ(weighed.certainty, Certainty::kDoubtful);
  EXPECT_EQ(weighed.match.status, MatchStatus::kRejectedContradiction);
  EXPECT_EQ(weighed.match.map_from_base, problem.predicted_map_from_base);
  EXPECT_GT(weighed.match.contradiction, 0.2);
  EXPECT_NEAR(weighed.match.covariance(0, 0), 0.03 * 0.03 + 0.5 * 0.5, 1e-12);
  EXPECT_NEAR(weighed.match.covariance(2, 2), 0.03 * 0.03 + 1.0, 1e-12);
}

TEST(Doubt, ASecondLookHasToConvince) {
  const MatchScene scene = scene_in_rooms(30.0);
  const Pose2 wrong = shifted(scene.map_from_base, {0.3, -0.25, 0.9});
  const ToldMatcher matcher(answer(wrong, 0.1, MatchStatus::kRejectedLowScore));
  const MatchProblem problem = scene.problem(wrong, prior_of(0.03, 0.03));
  const auto certainty_with = [&](const DoubtOptions& options) {
    return match_and_weigh(matcher, problem, scene.map.occupancy, {0.0, false}, options).certainty;
  };
  DoubtOptions options;
  EXPECT_EQ(certainty_with(options), Certainty::kSecondLook);
  options.least_score = 0.999;
  EXPECT_EQ(certainty_with(options), Certainty::kDoubtful);
  options.least_score = 0.4;
  options.look_theta = 0.1;  // not as far as the truth
  EXPECT_EQ(certainty_with(options), Certainty::kDoubtful);
}

TEST(Doubt, ASearchThatWasEndedEarlyDoesNotConvince) {
  const MatchScene scene = scene_in_rooms(30.0);
  MatchResult match = answer(scene.map_from_base, 0.9, MatchStatus::kAccepted);
  match.proof.emplace();
  match.proof->best_score = 0.9;
  match.proof->remaining_bound = 0.9;
  EXPECT_TRUE(is_convincing(match, {}));
  match.proof->remaining_bound = 0.95;
  EXPECT_FALSE(is_convincing(match, {}));
}

TEST(Doubt, AScoreLowerThanUsualIsLookedAtAgain) {
  const MatchScene scene = scene_in_rooms(30.0);
  const Pose2 beside = shifted(scene.map_from_base, {0.15, 0.0, 0.0});
  const ToldMatcher matcher(answer(beside, 0.6, MatchStatus::kAccepted));
  const MatchProblem problem = scene.problem(beside, prior_of(0.03, 0.03));
  const WeighedMatch first =
      match_and_weigh(matcher, problem, scene.map.occupancy, {0.6, false}, {});
  EXPECT_EQ(first.certainty, Certainty::kSure) << "as usual";
  const WeighedMatch second =
      match_and_weigh(matcher, problem, scene.map.occupancy, {0.95, false}, {});
  EXPECT_EQ(second.certainty, Certainty::kSecondLook);
  EXPECT_LT(distance(second.match.map_from_base, scene.map_from_base), 0.01);
}

TEST(Doubt, WhereNothingIsMappedThePredictionIsBelieved) {
  const MatchScene scene = scene_in_rooms(30.0);
  const Pose2 far = shifted(scene.map_from_base, {300.0, 0.0, 0.0});
  const MatchProblem problem = scene.problem(far, prior_of(0.03, 0.03));
  const WeighedMatch weighed =
      match_and_weigh(OlsonMatcher{}, problem, scene.map.occupancy, {0.0, false}, {});
  EXPECT_EQ(weighed.certainty, Certainty::kNewGround);
  EXPECT_EQ(weighed.match.map_from_base, far);
}

TEST(Doubt, OdometryAloneIsLeftToIt) {
  const MatchScene scene = scene_in_rooms(30.0);
  const Pose2 wrong = shifted(scene.map_from_base, {0.6, -0.4, 2.0});
  const MatchProblem problem = scene.problem(wrong, prior_of(0.03, 0.03));
  const auto certainty_of = [&](double score) {
    MatchResult one = answer(wrong, score, MatchStatus::kAccepted);
    one.candidates = 1;
    return match_and_weigh(ToldMatcher(one), problem, scene.map.occupancy, {}, {}).certainty;
  };
  EXPECT_EQ(certainty_of(0.0), Certainty::kSure);
  EXPECT_EQ(certainty_of(1.0), Certainty::kSecondLook) << "a search that had one candidate is none";
}

TEST(Doubt, AMatchIsWeighedByHowItFitsTheMapNotByTheMatchersOwnScore) {
  const MatchScene scene = scene_in_rooms(30.0);
  const MatchProblem problem = scene.problem(scene.map_from_base, prior_of(0.03, 0.03));
  const ToldMatcher matcher(answer(scene.map_from_base, 0.3, MatchStatus::kAccepted));
  const WeighedMatch weighed =
      match_and_weigh(matcher, problem, scene.map.occupancy, {0.9, false}, {});
  EXPECT_EQ(weighed.certainty, Certainty::kSure);
  EXPECT_EQ(weighed.match.score, 0.3) << "told as the matcher gave it";
  EXPECT_GT(weighed.fit, 0.8);
}

TEST(Doubt, ASecondLookThatFindsThePredictionIsNoJump) {
  const MatchScene scene = scene_in_rooms(30.0);
  const auto look_from = [&](const Eigen::Vector3d& off) {
    const Pose2 predicted = shifted(scene.map_from_base, off);
    const ToldMatcher matcher(answer(predicted, 0.1, MatchStatus::kRejectedLowScore));
    return match_and_weigh(matcher, scene.problem(predicted, prior_of(0.03, 0.03)),
                           scene.map.occupancy, {}, {});
  };
  EXPECT_EQ(look_from({0.05, -0.05, 0.02}).certainty, Certainty::kSecondLook);
  EXPECT_FALSE(look_from({0.05, -0.05, 0.02}).jumped);
  EXPECT_TRUE(look_from({0.3, -0.2, 0.0}).jumped);
  EXPECT_TRUE(look_from({0.0, 0.0, 0.5}).jumped);
}

/// Of a wall, 16 cm thick, one side is mapped, and so is a wall across; a robot that came round
/// sees the other side. By the prediction it is right, which the mapped side fits better.
class BackOfAWall : public testing::Test {
 protected:
  BackOfAWall() {
    std::vector<SurfaceHit> hits;
    for (double y = -2.0; y < 2.0; y += 0.02) {
      hits.push_back({{0.0, y}, {-1.0, 0.0}});
      add({0.16, y}, {1.0, 0.0});
    }
    for (double x = -2.0; x < 4.0; x += 0.02) {
      hits.push_back({{x, 2.0}, {0.0, -1.0}});
    }
    map_.field.update(hits, {});
    for (int x = -40; x < 0; ++x) {
      for (int y = -40; y < 40; ++y) {
        map_.occupancy.blend({x, y}, 0.0, 1.0);
      }
    }
  }

  void add(const Eigen::Vector2d& position, const Eigen::Vector2d& normal) {
    scan_.points.push_back({position, {1.5, 0.0}, normal, 0.02, false});
  }

  [[nodiscard]] WeighedMatch weigh() const {
    const ToldMatcher matcher(answer({-0.16, 0.0, 0.0}, 0.9, MatchStatus::kAccepted));
    return match_and_weigh(matcher, {scan_, {}, prior_of(0.3, 0.1), map_.field, {}, 1},
                           map_.occupancy, {}, {});
  }

  SlamMap map_{MapOptions{}, LikelihoodFieldOptions{}};
  PointScan scan_;
};

TEST_F(BackOfAWall, IsNotItsFront) {
  for (double x = 0.3; x < 4.0; x += 0.02) {
    add({x, 2.0}, {0.0, -1.0});
  }
  const WeighedMatch weighed = weigh();
  EXPECT_EQ(weighed.certainty, Certainty::kSecondLook);
  EXPECT_LT(distance(weighed.match.map_from_base, {}), 0.02);
  EXPECT_LT(weighed.match.contradiction, 0.01);
}

TEST_F(BackOfAWall, IsNewGroundWhereNothingElseIsMapped) {
  const WeighedMatch weighed = weigh();
  EXPECT_EQ(weighed.certainty, Certainty::kNewGround);
  EXPECT_EQ(weighed.match.map_from_base, Pose2{});
}

}  // namespace
}  // namespace matchbox_slam
