#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

/// The same map, and a scan of another place.
MatchScene elsewhere() {
  const World other = make_random_world(1);
  const Eigen::Vector2d start = other.route().waypoints.front();
  MatchScene there = rooms_scene();
  there.scan = look_around(other, LaserOptions{}, {start.x(), start.y(), 0.0}, 1);
  return there;
}

Pose2 prediction() { return shifted(rooms_scene().map_from_base, {0.1, -0.08, 0.05}); }

MatchResult match(const MonteCarloOptions& options, std::uint64_t seed = 1) {
  return MonteCarloMatcher(options).match(
      rooms_scene().problem(prediction(), prior_of(0.1, 0.06), seed));
}

std::size_t candidates(const MonteCarloOptions& options) { return match(options).candidates; }

/// What 120 matches at many places, predicted as wrongly as their prior says, came to.
struct Statistics {
  std::vector<double> errors_xy;
  std::vector<double> errors_theta;
  double mean_nees = 0.0;
  int missed = 0;  ///< off by more than 2 cm or 10 mrad
};

Statistics match_everywhere(const MonteCarloOptions& options) {
  constexpr double kSigmaXy = 0.1;
  constexpr double kSigmaTheta = 0.06;
  const MonteCarloMatcher matcher(options);
  Statistics statistics;
  Random random(2);
  int count = 0;
  for (std::uint64_t place = 0; place < 12; ++place) {
    const World world = make_world(place % 3 == 0   ? "rooms"
                                   : place % 3 == 1 ? "random"
                                                    : "loop",
                                   place);
    const MatchScene here =
        make_match_scene(world, LaserOptions{}, 8.0 + 3.0 * static_cast<double>(place), place);
    for (std::uint64_t i = 0; i < 10; ++i) {
      const double x = kSigmaXy * random.gaussian();
      const double y = kSigmaXy * random.gaussian();
      const Pose2 predicted = shifted(here.map_from_base, {x, y, kSigmaTheta * random.gaussian()});
      const MatchResult result =
          matcher.match(here.problem(predicted, prior_of(kSigmaXy, kSigmaTheta), i));
      EXPECT_TRUE(result.accepted());
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(result.covariance);
      EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
      const Eigen::Vector3d error = shift_between(here.map_from_base, result.map_from_base);
      const bool found = error.head<2>().norm() <= 0.02 && std::abs(error.z()) <= 0.01;
      statistics.missed += found ? 0 : 1;
      if (found) {
        statistics.mean_nees += normalised_error_square(result, here.map_from_base);
        ++count;
      }
      statistics.errors_xy.push_back(error.head<2>().norm());
      statistics.errors_theta.push_back(std::abs(error.z()));
    }
  }
  statistics.mean_nees /= count;
  std::sort(statistics.errors_xy.begin(), statistics.errors_xy.end());
  std::sort(statistics.errors_theta.begin(), statistics.errors_theta.end());
  return statistics;
}

TEST(MonteCarlo, FindsKnownShiftsAndKnowsHowWell) {
  for (const int samples : {32, 0}) {
    MonteCarloOptions options;
    options.covariance_samples = samples;
    const Statistics statistics = match_everywhere(options);
    const std::size_t middle = statistics.errors_xy.size() / 2;
    // Measured: none missed, 0.7 mm and 0.15 mrad, at worst 4.2 mm and 0.5 mrad.
    EXPECT_LE(statistics.missed, 1);
    EXPECT_LT(statistics.errors_xy[middle], 0.0011);
    EXPECT_LT(statistics.errors_theta[middle], 0.00023);
    // 3 for a covariance that is exactly right; the map's own errors are common to all ten matches
    // of a place, so that the mean over 12 places is a rough one. Measured: 1.1.
    EXPECT_GT(statistics.mean_nees, 0.5);
    EXPECT_LT(statistics.mean_nees, 12.0);
  }
}

TEST(MonteCarlo, TheCovarianceHoldsTheCellWhereNothingRefines) {
  MonteCarloOptions options;
  options.refinement.iterations = 0;
  const double nees = match_everywhere(options).mean_nees;  // of those within 2 cm
  EXPECT_GT(nees, 0.5);
  EXPECT_LT(nees, 5.0);
}

TEST(MonteCarlo, TheSeedIsTheOnlyRandomness) {
  MonteCarloOptions options;
  options.refinement.iterations = 0;  // which would hide where the search ended
  const MatchResult a = match(options, 1);
  const MatchResult b = match(options, 1);
  const MatchResult c = match(options, 2);
  EXPECT_EQ(a.map_from_base, b.map_from_base);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_NE(a.map_from_base, c.map_from_base);
}

TEST(MonteCarlo, NeverTriesMoreThanItMay) {
  for (const int max_tries : {1, 2, 57, 300, 1000}) {
    for (const double enough_score : {0.0, 1.0}) {
      MonteCarloOptions options;
      options.max_tries = max_tries;
      options.enough_score = enough_score;
      EXPECT_GE(candidates(options), 1U);
      EXPECT_LE(candidates(options), static_cast<std::size_t>(max_tries) + 1);
    }
  }
}

TEST(MonteCarlo, EndsAfterFailedTriesInARow) {
  MonteCarloOptions options;
  options.enough_score = 0.0;
  options.max_tries = 100000;
  options.max_failed_tries = 20;
  const std::size_t with_few = candidates(options);
  EXPECT_GE(with_few, 20U);
  options.max_failed_tries = 200;
  EXPECT_GE(candidates(options), 200U);
  EXPECT_GT(candidates(options), with_few);
  EXPECT_LT(candidates(options), 100000U);
}

TEST(MonteCarlo, WithoutResetFailedTriesAddUp) {
  MonteCarloOptions options;
  options.enough_score = 0.0;
  options.max_tries = 100000;
  options.reset_on_success = false;
  const std::size_t without = candidates(options);
  options.reset_on_success = true;
  EXPECT_LT(without, candidates(options));
}

TEST(MonteCarlo, SearchesAgainUntilThePoseFitsWellEnough) {
  MonteCarloOptions options;
  options.max_failed_tries = 20;
  options.max_tries = 3000;
  options.enough_score = 1.0;
  EXPECT_GE(candidates(options), 3000U);
  options.enough_score = 0.0;
  EXPECT_LT(candidates(options), 1000U);
}

TEST(MonteCarlo, SparesTheTriesThatAreLeftWhereTheScanFitsAndSpendsThemWhereNot) {
  const MonteCarloOptions options;
  const auto most = static_cast<std::size_t>(options.max_tries);
  EXPECT_LT(candidates(options), most / 2);
  const MatchScene scan_elsewhere = elsewhere();
  const MatchProblem problem = scan_elsewhere.problem(prediction(), prior_of(0.1, 0.06));
  EXPECT_EQ(MonteCarloMatcher(options).match(problem).candidates, most);
}

TEST(MonteCarlo, TellsWhereItsSearchEnded) {
  MonteCarloOptions search_only;
  search_only.refinement.iterations = 0;
  const MatchResult raw = match(search_only);
  EXPECT_EQ(raw.refined_by, Eigen::Vector3d::Zero());
  const MatchResult refined = match({});
  EXPECT_GT(refined.refined_by.norm(), 0.002);
  EXPECT_LT(difference(refined.searched_map_from_base(), raw.map_from_base).norm(), 1e-12);
}

TEST(MonteCarlo, MoreTriesFindMore) {
  MonteCarloOptions few;
  few.max_tries = 5;
  few.enough_score = 1.0;
  few.refinement.iterations = 0;
  MonteCarloOptions many = few;
  many.max_tries = 20000;
  many.max_failed_tries = 1000;
  const auto error = [](const MatchResult& result) {
    return shift_between(rooms_scene().map_from_base, result.map_from_base).norm();
  };
  EXPECT_LT(error(match(many)), 0.03);
  EXPECT_GT(error(match(few)), error(match(many)));
}

TEST(MonteCarlo, RejectsWhatDoesNotFit) {
  const MatchScene scan_elsewhere = elsewhere();
  MonteCarloOptions strict;
  strict.min_score = 0.8;
  const MatchProblem problem = scan_elsewhere.problem(prediction(), prior_of(0.1, 0.06));
  const MatchResult result = MonteCarloMatcher(strict).match(problem);
  EXPECT_EQ(result.status, MatchStatus::kRejectedLowScore);
  EXPECT_EQ(result.map_from_base, prediction());
  EXPECT_EQ(result.covariance, prior_of(0.1, 0.06));
  EXPECT_LT(result.score, 0.8);
  EXPECT_GT(result.candidates, 1U);
  MonteCarloOptions anything;
  anything.min_score = 0.0;
  EXPECT_TRUE(MonteCarloMatcher(anything).match(problem).accepted());
  EXPECT_TRUE(MonteCarloMatcher(strict)
                  .match(rooms_scene().problem(prediction(), prior_of(0.1, 0.06)))
                  .accepted());
}

TEST(MonteCarlo, SaysWhyThereIsNoMatch) {
  const MonteCarloMatcher matcher;
  MatchScene changed = rooms_scene();
  changed.map = SlamMap(MapOptions{}, LikelihoodFieldOptions{});
  EXPECT_EQ(matcher.match(changed.problem(prediction(), prior_of(0.1, 0.06))).status,
            MatchStatus::kRejectedNoReference);
  changed = rooms_scene();
  changed.scan.points.clear();
  EXPECT_EQ(matcher.match(changed.problem(prediction(), prior_of(0.1, 0.06))).status,
            MatchStatus::kRejectedTooFewPoints);
  EXPECT_EQ(
      matcher.match(rooms_scene().problem({std::nan(""), 0.0, 0.0}, prior_of(0.1, 0.06))).status,
      MatchStatus::kRejectedInvalidPrior);
}

TEST(MonteCarlo, ConfigurationErrorsNameTheOption) {
  MonteCarloMatcher matcher;
  Parameters parameters;
  parameters.set("max_tries", 0);
  std::string text = error_text<ConfigurationError>([&] { matcher.configure(parameters); });
  EXPECT_TRUE(contains(text, "monte_carlo/max_tries: 0 is not allowed")) << text;
  parameters.set("max_tries", 10);
  parameters.set("max_trys", 10);
  text = error_text<ConfigurationError>([&] { matcher.configure(parameters); });
  EXPECT_TRUE(contains(text, "did you mean 'max_tries'?")) << text;
}

}  // namespace
}  // namespace matchbox_slam
