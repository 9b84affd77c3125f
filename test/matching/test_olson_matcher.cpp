#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/olson_matcher.hpp"
#include "matchbox_slam/simulation/make_world.hpp"
#include "matching/match_scene.hpp"

namespace matchbox_slam {
namespace {

const MatchScene& scene() {
  static const MatchScene kRooms = make_match_scene(make_rooms_world(7), LaserOptions{}, 15.0, 1);
  return kRooms;
}

MatchResult match(const OlsonOptions& options, const Eigen::Vector3d& off,
                  const Eigen::Matrix3d& prior) {
  return OlsonMatcher(options).match(scene().problem(shifted(scene().map_from_base, off), prior));
}

Eigen::Vector3d error_of(const MatchResult& result) {
  return shift_between(scene().map_from_base, result.map_from_base);
}

/// The search's own answer, which no refinement hides.
OlsonOptions search_only() {
  OlsonOptions options;
  options.refinement.iterations = 0;
  return options;
}

TEST(Olson, ProvesThatNothingInTheWindowIsBetter) {
  const MatchResult result = match({}, {0.1, -0.08, 0.05}, prior_of(0.1, 0.06));
  ASSERT_TRUE(result.accepted());
  ASSERT_TRUE(result.proof);
  EXPECT_EQ(result.proof->gap(), 0.0);
  EXPECT_GT(result.proof->best_score, 0.5);
  EXPECT_LT(error_of(result).head<2>().norm(), 0.003);
  EXPECT_LT(std::abs(error_of(result).z()), 0.0005);
}

TEST(Olson, ComesWithinAStepBeforeItRefines) {
  for (const char* likelihood : {"linear", "log"}) {
    for (const char* weighting : {"walls", "beams"}) {
      for (const double spacing : {0.0, 0.025}) {
        OlsonOptions options = search_only();
        options.likelihood = likelihood;
        options.weighting = weighting;
        options.point_spacing = spacing;
        options.step_xy = 0.01;
        const Eigen::Vector3d error =
            error_of(match(options, {0.1, -0.08, 0.05}, prior_of(0.1, 0.06)));
        // Half a cell of the field.
        EXPECT_LT(error.head<2>().norm(), 0.025) << likelihood << weighting << spacing;
        EXPECT_LT(std::abs(error.z()), 0.0045) << likelihood << weighting << spacing;
      }
    }
  }
}

TEST(Olson, WidensTheWindowWhoseEdgeIsBest) {
  OlsonOptions options = search_only();
  options.window_xy = 0.1;
  options.window_theta = 0.02;
  options.prior_weight = 0.001;
  options.widenings = 0;
  const Eigen::Vector3d off(0.3, 0.0, 0.05);
  const Eigen::Matrix3d prior = prior_of(0.3, 0.1);
  EXPECT_GT(error_of(match(options, off, prior)).norm(), 0.15);
  options.widenings = 2;
  EXPECT_LT(error_of(match(options, off, prior)).norm(), 0.04);
  options.max_window_xy = 0.15;
  EXPECT_GT(error_of(match(options, off, prior)).norm(), 0.1);
}

TEST(Olson, FindsItsWayFromFar) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const double x = random.uniform(-1.0, 1.0);
    const double y = random.uniform(-1.0, 1.0);
    const MatchResult result =
        match({}, {x, y, random.uniform(-kPi / 4.0, kPi / 4.0)}, prior_of(0.58, 0.45));
    EXPECT_LT(error_of(result).norm(), 0.004) << i;
    EXPECT_EQ(result.proof->gap(), 0.0);
  }
}

TEST(Olson, KeepsToItsDeadlineAndTellsTheGap) {
  OlsonOptions options;
  options.deadline = 1e-9;
  options.window_xy = 2.0;
  options.window_theta = 0.5;
  const MatchResult result = match(options, {0.7, -0.4, 0.2}, prior_of(0.5, 0.3));
  ASSERT_TRUE(result.proof);
  EXPECT_GT(result.proof->gap(), 0.0);
}

/// A map that shows the same corner twice, and a scan of it taken between the two.
struct TwoPlaces {
  MatchScene scene;
  double apart;
};

TwoPlaces two_places(double apart) {
  TwoPlaces places{{}, apart};
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 80; ++i) {
    const double along = 0.02 * i;
    for (const auto& [point, normal] :
         {std::pair{Eigen::Vector2d(along, 0.0), Eigen::Vector2d(0.0, 1.0)},
          std::pair{Eigen::Vector2d(0.0, along), Eigen::Vector2d(1.0, 0.0)}}) {
      for (const double side : {-0.5, 0.5}) {
        hits.push_back({point + Eigen::Vector2d(side * apart, side * apart), normal});
      }
      places.scene.scan.points.push_back({point, {-1.0, -1.0}, normal, 0.02, false});
    }
  }
  places.scene.map.field.update(hits, {});
  return places;
}

TEST(Olson, TellsARivalAndCoversIt) {
  const TwoPlaces twice = two_places(0.8);
  const MatchResult result =
      OlsonMatcher().match(twice.scene.problem({0.01, 0.01, 0.0}, prior_of(0.4, 0.05)));
  ASSERT_TRUE(result.accepted());
  EXPECT_GT(result.rival_share, 0.97);
  EXPECT_NEAR(std::abs(result.map_from_base.x), 0.4, 0.01);
  // Two places 0.8 m apart that are as likely have a standard deviation of 0.4 m along each axis.
  EXPECT_NEAR(std::sqrt(result.covariance(0, 0)), 0.4, 0.05);
  const MatchResult alone = match({}, {0.1, 0.1, 0.0}, prior_of(0.4, 0.05));
  EXPECT_LT(alone.rival_share, 0.9);
  EXPECT_LT(std::sqrt(alone.covariance(0, 0)), 0.003);
}

TEST(Olson, KeepsTheOdometryAlongACorridor) {
  const World world = make_corridor_world(1);
  Random random(5);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const MatchScene here =
        make_match_scene(world, LaserOptions{}, 10.0 + 3.0 * static_cast<double>(i), i);
    const Eigen::Vector3d off(random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1),
                              random.uniform(-0.05, 0.05));
    const MatchResult result =
        OlsonMatcher().match(here.problem(shifted(here.map_from_base, off), prior_of(0.12, 0.05)));
    const Eigen::Vector3d error = shift_between(here.map_from_base, result.map_from_base);
    ASSERT_EQ(result.unconstrained_directions.size(), 1U);
    EXPECT_GT(std::abs(result.unconstrained_directions[0].x()), 0.999);
    EXPECT_NEAR(error.x(), off.x(), 0.005);
    EXPECT_NEAR(std::sqrt(result.covariance(0, 0)), 0.12, 0.005);
    EXPECT_LT(std::abs(error.y()), 0.005);
    EXPECT_LT(std::abs(error.z()), 0.001);
  }
}

TEST(Olson, RejectsWhatDoesNotFit) {
  OlsonOptions strict;
  strict.min_score = 1.0;
  const Pose2 predicted = shifted(scene().map_from_base, {0.1, 0.1, 0.0});
  const MatchResult result =
      OlsonMatcher(strict).match(scene().problem(predicted, prior_of(0.1, 0.06)));
  EXPECT_EQ(result.status, MatchStatus::kRejectedLowScore);
  EXPECT_EQ(result.map_from_base, predicted);
  EXPECT_EQ(result.covariance, prior_of(0.1, 0.06));
  EXPECT_GT(result.score, 0.5);
}

TEST(Olson, ConfigurationErrorsNameTheOption) {
  OlsonMatcher matcher;
  Parameters parameters;
  parameters.set("likelihood", "square");
  std::string text = error_text<ConfigurationError>([&] { matcher.configure(parameters); });
  EXPECT_TRUE(contains(text, "olson/likelihood")) << text;
  parameters.set("likelihood", "log");
  parameters.set("step", 0.1);
  text = error_text<ConfigurationError>([&] { matcher.configure(parameters); });
  EXPECT_TRUE(contains(text, "olson")) << text;
}

}  // namespace
}  // namespace matchbox_slam
