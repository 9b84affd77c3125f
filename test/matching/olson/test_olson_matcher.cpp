#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

MatchResult match(const OlsonOptions& options, const Eigen::Vector3d& off,
                  const Eigen::Matrix3d& prior) {
  return OlsonMatcher(options).match(
      rooms_scene().problem(shifted(rooms_scene().map_from_base, off), prior));
}

Eigen::Vector3d error_of(const MatchResult& result) {
  return shift_between(rooms_scene().map_from_base, result.map_from_base);
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

TEST(Olson, FindsNothingThatExplainsLessThanTheFloor) {
  const Eigen::Vector3d off(0.1, -0.08, 0.05);
  const MatchResult any = match({}, off, prior_of(0.1, 0.06));
  OlsonOptions options;
  options.search_floor = any.proof->best_score - 0.01;
  EXPECT_EQ(match(options, off, prior_of(0.1, 0.06)).map_from_base, any.map_from_base);
  options.search_floor = any.proof->best_score + 0.01;
  const MatchResult none = match(options, off, prior_of(0.1, 0.06));
  EXPECT_EQ(none.status, MatchStatus::kRejectedLowScore);
  EXPECT_LT(none.candidates, any.candidates);
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
        // Half a cell of the field; 22 mm is the most that is measured.
        EXPECT_LT(error.head<2>().norm(), 0.025) << likelihood << weighting << spacing;
        EXPECT_LT(std::abs(error.z()), 0.0045) << likelihood << weighting << spacing;
      }
    }
  }
}

/// Mean over many places of the squared error over its covariance; 3 if that is honest.
double mean_nees(const OlsonOptions& options) {
  constexpr int kPlaces = 12;
  constexpr int kOffsets = 5;
  Random random(4);
  double sum = 0.0;
  for (std::uint64_t place = 0; place < kPlaces; ++place) {
    const MatchScene here = make_match_scene(make_rooms_world(place), LaserOptions{},
                                             6.0 + 2.0 * static_cast<double>(place), place);
    for (int i = 0; i < kOffsets; ++i) {
      const double x = random.uniform(-0.15, 0.15);
      const double y = random.uniform(-0.15, 0.15);
      const Eigen::Vector3d off(x, y, random.uniform(-0.1, 0.1));
      const MatchResult result = OlsonMatcher(options).match(
          here.problem(shifted(here.map_from_base, off), prior_of(0.1, 0.06)));
      sum += normalised_error_square(result, here.map_from_base);
    }
  }
  return sum / (kPlaces * kOffsets);
}

TEST(Olson, TheCovarianceHoldsTheStepWhereNothingRefines) {
  OlsonOptions options = search_only();
  for (const double step : {0.05, 0.025}) {
    options.step_xy = step;
    const double nees = mean_nees(options);
    EXPECT_GT(nees, 1.0) << step;
    EXPECT_LT(nees, 5.0) << step;
  }
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

TEST(Olson, BelievesTheScanWhereThePriorIsWrong) {
  // Odometry missed a turn: seven standard deviations, which would cost more than a perfect fit.
  OlsonOptions options;
  options.window_theta = 0.3;
  const MatchResult result = match(options, {0.0, 0.0, 0.2}, prior_of(0.05, 0.03));
  ASSERT_TRUE(result.accepted());
  EXPECT_LT(error_of(result).norm(), 0.004);
}

TEST(Olson, TellsAWindowThatIsNarrowerThanThePrior) {
  const Eigen::Vector3d off(0.3, 0.2, 0.1);
  const MatchResult wide = match({}, off, prior_of(1.6, 0.1));
  ASSERT_TRUE(wide.accepted());
  EXPECT_TRUE(wide.proof->is_proven());
  EXPECT_FALSE(wide.proof->clipped);
  EXPECT_LT(std::sqrt(wide.covariance(0, 0)), 0.003);
  OlsonOptions narrow;
  narrow.max_window_xy = 1.6;
  const MatchResult clipped = match(narrow, off, prior_of(1.6, 0.1));
  EXPECT_LT(error_of(clipped).norm(), 0.004);
  EXPECT_EQ(clipped.proof->gap(), 0.0);
  EXPECT_TRUE(clipped.proof->clipped);
  EXPECT_FALSE(clipped.proof->is_proven());
  // A third of a Gaussian lies beyond one standard deviation, less what lies beyond three.
  EXPECT_NEAR(clipped.covariance(0, 0), (0.3173 - 0.0027) * 1.6 * 1.6, 0.01);
  narrow.window_xy = 1.5;  // asked for, whatever the prior says
  EXPECT_TRUE(match(narrow, off, prior_of(1.6, 0.1)).proof->is_proven());
}

TEST(Olson, TellsThatTheBestPoseLiesOnTheEdge) {
  OlsonOptions options;
  options.window_xy = 0.1;
  options.window_theta = 0.02;
  const Eigen::Matrix3d prior = prior_of(0.3, 0.1);
  EXPECT_TRUE(match(options, {0.3, 0.0, 0.0}, prior).proof->on_edge);
  EXPECT_TRUE(match(options, {0.0, 0.0, 0.06}, prior).proof->on_edge);
  EXPECT_FALSE(match(options, {0.03, 0.03, 0.005}, prior).proof->on_edge);
  EXPECT_FALSE(match({}, {0.0, 0.0, 0.0}, Eigen::Matrix3d::Zero()).proof->on_edge);
  options = {};
  options.window_theta = kPi;  // has no edge
  EXPECT_FALSE(match(options, {0.0, 0.0, kPi}, prior_of(0.1, 3.0)).proof->on_edge);
}

TEST(Olson, ItsProofIsOfThePoseBeforeRefinement) {
  const Eigen::Vector3d off(0.107, -0.083, 0.051);
  const Eigen::Matrix3d prior = prior_of(0.1, 0.06);
  const MatchResult raw = match(search_only(), off, prior);
  EXPECT_EQ(raw.proof->map_from_base, raw.map_from_base);
  EXPECT_EQ(raw.refined_by, Eigen::Vector3d::Zero());
  const MatchResult refined = match({}, off, prior);
  EXPECT_EQ(refined.proof->map_from_base, raw.map_from_base);
  EXPECT_GT(refined.refined_by.norm(), 0.002);
  EXPECT_LT((difference(refined.map_from_base, raw.map_from_base) - refined.refined_by).norm(),
            1e-12);
  OlsonOptions strict;
  strict.min_score = 1.0;
  EXPECT_EQ(match(strict, off, prior).refined_by, Eigen::Vector3d::Zero());
}

TEST(Olson, KeepsToItsDeadlineAndTellsTheGap) {
  OlsonOptions options;
  options.deadline = 1e-9;
  options.min_score = 0.0;
  options.window_xy = 2.0;
  options.window_theta = 0.5;
  const MatchResult result = match(options, {0.7, -0.4, 0.2}, prior_of(0.5, 0.3));
  ASSERT_TRUE(result.proof);
  EXPECT_GT(result.proof->gap(), 0.0);
  EXPECT_GE(result.covariance(0, 0), 0.25) << "anything that the prior allows may be the truth";
  options.deadline = 60.0;
  const MatchResult in_time = match(options, {0.7, -0.4, 0.2}, prior_of(0.5, 0.3));
  EXPECT_EQ(in_time.proof->gap(), 0.0);
  EXPECT_LT(error_of(in_time).norm(), 0.004);
}

TEST(Olson, EndsAfterSoManyLookUpsTheSameEachTime) {
  OlsonOptions options;
  options.most_look_ups = 1;
  options.min_score = 0.0;
  options.window_xy = 2.0;
  options.window_theta = 0.5;
  const Eigen::Vector3d off(0.7, -0.4, 0.2);
  const MatchResult result = match(options, off, prior_of(0.5, 0.3));
  ASSERT_TRUE(result.proof);
  EXPECT_GT(result.proof->gap(), 0.0);
  EXPECT_GE(result.covariance(0, 0), 0.25) << "anything that the prior allows may be the truth";
  EXPECT_EQ(result.map_from_base, match(options, off, prior_of(0.5, 0.3)).map_from_base);
  options.most_look_ups = 0;
  const MatchResult whole = match(options, off, prior_of(0.5, 0.3));
  EXPECT_EQ(whole.proof->gap(), 0.0);
  EXPECT_GT(whole.candidates, result.candidates);
  EXPECT_LT(error_of(whole).norm(), 0.004);
}

TEST(Olson, CanBeAskedAnythingWithoutHarm) {
  const Pose2 predicted = shifted(rooms_scene().map_from_base, {0.05, 0.0, 0.0});
  const OlsonMatcher matcher;
  const Eigen::Vector3d line(1.0, 0.5, 0.3);
  for (const Eigen::Matrix3d& prior :
       {Eigen::Matrix3d(0.01 * line * line.transpose()), Eigen::Matrix3d(prior_of(1e100, 1e100)),
        Eigen::Matrix3d(Eigen::Matrix3d::Zero())}) {
    const MatchResult result = matcher.match(rooms_scene().problem(predicted, prior));
    EXPECT_TRUE(result.covariance.allFinite());
    EXPECT_GE(result.covariance.diagonal().minCoeff(), 0.0) << prior;
    EXPECT_GE(result.proof->best_score, 0.0);
  }
  for (const double far : {1e7, 1e10}) {
    const MatchResult result =
        matcher.match(rooms_scene().problem({far, far, 0.0}, prior_of(0.1, 0.06)));
    EXPECT_FALSE(result.accepted());
  }
  MatchScene heavy = rooms_scene();
  for (ScanPoint& point : heavy.scan.points) {
    point.weight = 1e308;
  }
  EXPECT_FALSE(matcher.match(heavy.problem(predicted, prior_of(0.1, 0.06))).accepted());
}

/// A map that shows the same corner twice, and a scan of it taken between the two.
MatchScene two_places(double apart) {
  MatchScene scene;
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 80; ++i) {
    const double along = 0.02 * i;
    for (const auto& [point, normal] :
         {std::pair{Eigen::Vector2d(along, 0.0), Eigen::Vector2d(0.0, 1.0)},
          std::pair{Eigen::Vector2d(0.0, along), Eigen::Vector2d(1.0, 0.0)}}) {
      for (const double side : {-0.5, 0.5}) {
        hits.push_back({point + Eigen::Vector2d(side * apart, side * apart), normal});
      }
      scene.scan.points.push_back({point, {-1.0, -1.0}, normal, 0.02, false});
    }
  }
  scene.map.field.update(hits, {});
  return scene;
}

TEST(Olson, TellsARivalAndCoversIt) {
  const MatchScene twice = two_places(0.8);
  const MatchResult result =
      OlsonMatcher().match(twice.problem({0.01, 0.01, 0.0}, prior_of(0.4, 0.05)));
  ASSERT_TRUE(result.accepted());
  EXPECT_GT(result.rival_share, 0.97);
  EXPECT_NEAR(std::abs(result.map_from_base.x), 0.4, 0.01);
  // Two places 0.8 m apart that are as likely have a standard deviation of 0.4 m along each axis.
  EXPECT_NEAR(std::sqrt(result.covariance(0, 0)), 0.4, 0.05);
  const MatchResult alone = match({}, {0.1, 0.1, 0.0}, prior_of(0.4, 0.05));
  EXPECT_LT(alone.rival_share, 0.9);
  EXPECT_LT(std::sqrt(alone.covariance(0, 0)), 0.003);
}

TEST(Olson, TellsThatItLeftOutTheRestOfAWindowThatIsTooWide) {
  MatchScene fine = two_places(0.2);
  LikelihoodFieldOptions field;
  field.reach = 0.1;
  fine.map = SlamMap(
      [] {
        MapOptions map;
        map.resolution = 0.005;
        return map;
      }(),
      field);
  std::vector<SurfaceHit> hits;
  for (const ScanPoint& point : fine.scan.points) {
    hits.push_back({point.position, point.normal});
  }
  fine.map.field.update(hits, {});
  OlsonOptions options;
  options.window_xy = 100.0;
  options.window_theta = 0.01;
  const MatchResult result = OlsonMatcher(options).match(fine.problem({}, prior_of(0.1, 0.01)));
  EXPECT_LT(result.map_from_base.translation().norm(), 0.01);
  EXPECT_TRUE(result.proof->clipped);
  EXPECT_FALSE(result.proof->is_proven());
}

TEST(Olson, AlongACorridorTheWayIsAsSureAsThePriorHoweverWideThatIs) {
  MatchScene corridor;
  std::vector<SurfaceHit> hits;
  for (int i = -2000; i <= 2000; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d point(0.02 * i, side);
      hits.push_back({point, {0.0, -side}});
      if (std::abs(i) < 200) {
        corridor.scan.points.push_back({point, {0.0, 0.0}, {0.0, -side}, 0.02, false});
      }
    }
  }
  corridor.map.field.update(hits, {});
  const MatchResult result =
      OlsonMatcher().match(corridor.problem({0.3, 0.01, 0.0}, prior_of(10.0, 0.02)));
  ASSERT_TRUE(result.accepted());
  EXPECT_TRUE(result.proof->clipped);
  EXPECT_NEAR(result.covariance(0, 0), 100.0, 1.0);
}

TEST(Olson, LooksForRivalsOnlyAboveTheLeastShare) {
  const MatchScene twice = two_places(0.8);
  OlsonOptions options;
  options.least_rival = 1.0;
  const MatchProblem problem = twice.problem({0.01, 0.01, 0.0}, prior_of(0.4, 0.05));
  EXPECT_EQ(OlsonMatcher(options).match(problem).rival_share, 0.0);
  options.least_rival = 0.3;
  const MatchProblem alone = rooms_scene().problem(
      shifted(rooms_scene().map_from_base, {0.1, 0.1, 0.0}), prior_of(0.4, 0.05));
  const double share = OlsonMatcher(options).match(alone).rival_share;
  EXPECT_GT(share, 0.3);
  EXPECT_LT(share, 0.8);
}

TEST(Olson, ThePriorOutweighsASlightlyBetterFitFarAway) {
  MatchScene twice = two_places(0.8);
  // A fourth of the walls of the place at (0.4, 0.4) is gone.
  std::vector<Cell> gone;
  for (const Cell& cell : twice.map.field.surface_cells()) {
    const Eigen::Vector2d at = twice.map.field.geometry().center(cell);
    if (std::max(at.x(), at.y()) > 0.4 + 1.2) {
      gone.push_back(cell);
    }
  }
  twice.map.field.update({}, gone);
  const MatchProblem problem = twice.problem({0.3, 0.3, 0.0}, prior_of(0.3, 0.05));
  OlsonOptions options;
  EXPECT_NEAR(OlsonMatcher(options).match(problem).map_from_base.x, 0.4, 0.01);
  options.prior_weight = 0.0;
  EXPECT_NEAR(OlsonMatcher(options).match(problem).map_from_base.x, -0.4, 0.01);
}

/// Few points at one place of the map and many at another, the few on longer walls.
MatchScene few_and_many() {
  MatchScene scene;
  std::vector<SurfaceHit> hits;
  const auto add = [&](int points, double weight, double shift) {
    for (int i = 0; i < points; ++i) {
      const Eigen::Vector2d point(2.0 * std::cos(2.4 * i + shift), 2.0 * std::sin(2.4 * i + shift));
      scene.scan.points.push_back({point, {0.0, 0.0}, {0.0, 0.0}, weight, false});
      hits.push_back({point + Eigen::Vector2d(shift, 0.0), {0.0, 0.0}});
    }
  };
  add(8, 0.1, 0.3);
  add(16, 0.00625, -0.3);
  scene.map.field.update(hits, {});
  return scene;
}

TEST(Olson, WeighsWallsOrBeams) {
  const MatchScene scene = few_and_many();
  OlsonOptions options = search_only();
  options.min_score = 0.0;
  const MatchProblem problem = scene.problem({0.0, 0.0, 0.0}, prior_of(0.3, 0.01));
  EXPECT_NEAR(OlsonMatcher(options).match(problem).map_from_base.x, 0.3, 0.03);
  options.weighting = "beams";
  EXPECT_NEAR(OlsonMatcher(options).match(problem).map_from_base.x, -0.3, 0.03);
}

TEST(Olson, ALogarithmForgivesSmallMisfitsMore) {
  OlsonOptions options = search_only();
  options.min_score = 0.0;
  options.window_xy = options.window_theta = 1e-6;
  const Eigen::Vector3d off(0.03, 0.03, 0.0);
  const double linear = match(options, off, prior_of(0.3, 0.1)).proof->best_score;
  options.likelihood = "log";
  EXPECT_GT(match(options, off, prior_of(0.3, 0.1)).proof->best_score, linear + 0.03);
}

TEST(Olson, ItsCovarianceIsTheSecondMomentOfThePosterior) {
  // Ends of walls, where the robust kernel makes the posterior anything but a Gaussian.
  MatchScene few;
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d point(2.0 * std::cos(1.7 * i), 2.0 * std::sin(1.7 * i));
    few.scan.points.push_back({point, {0.0, 0.0}, {0.0, 0.0}, 0.1, false});
    hits.push_back({point, {0.0, 0.0}});
  }
  few.map.field.update(hits, {});
  OlsonOptions options;
  options.refinement.noise = 0.03;
  const PosePrior prior{{}, prior_of(0.2, 0.1)};
  const MatchResult result =
      OlsonMatcher(options).match(few.problem(prior.map_from_base, prior.covariance));
  ASSERT_TRUE(result.accepted());
  const RefinedPose refined =
      refine(few.scan.points, few.map.field, prior.map_from_base, prior, options.refinement);
  const Correspondences pairs(few.scan.points, few.map.field, result.map_from_base);
  const LocalPosterior posterior(pairs, result.map_from_base, prior, options.refinement);
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double total = 0.0;
  for (int i = 0; i < 15 * 15 * 15; ++i) {
    const Eigen::Vector3i at(i % 15 - 7, i / 15 % 15 - 7, i / 225 - 7);
    const Eigen::Vector3d step =
        0.35 * refined.covariance.diagonal().cwiseSqrt().cwiseProduct(at.cast<double>());
    const double weight = std::exp(-posterior.cost(step));
    moment += weight * step * step.transpose();
    total += weight;
  }
  for (int k = 0; k < 3; ++k) {
    const double sigma = std::sqrt(moment(k, k) / total);
    EXPECT_NEAR(std::sqrt(result.covariance(k, k)), sigma, 0.05 * sigma) << k;
    EXPECT_GT(std::abs(std::sqrt(refined.covariance(k, k)) - sigma), 0.1 * sigma) << k;
  }
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
  const Pose2 predicted = shifted(rooms_scene().map_from_base, {0.1, 0.1, 0.0});
  const MatchResult result =
      OlsonMatcher(strict).match(rooms_scene().problem(predicted, prior_of(0.1, 0.06)));
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
