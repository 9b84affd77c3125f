#include <gtest/gtest.h>

#include <cmath>

#include "matching/match_scene.hpp"
#include "slam/prior_odds.hpp"

namespace matchbox_slam {
namespace {

/// A scan predicted at the origin; what odometry has shown is `learned` of what is searched.
class PriorOdds : public testing::Test {
 protected:
  [[nodiscard]] MatchProblem problem(double learned) const {
    return {scan_, {}, learned * learned * searched_, map_.field, none_, 1, searched_};
  }

  Eigen::Matrix3d searched_ = prior_of(0.1, 0.05);

 private:
  PointScan scan_;
  PlacedScans none_;
  SlamMap map_{MapOptions{}, LikelihoodFieldOptions{}};
};

TEST_F(PriorOdds, AreThoseOfWhatOdometryHasShownNearby) {
  EXPECT_NEAR(prior_log_odds(problem(0.2), {}), 0.0, 1e-12);
  EXPECT_NEAR(prior_log_odds(problem(0.2), {0.04, 0.0, 0.0}), -2.0, 1e-9) << "two of 0.02 m";
  EXPECT_NEAR(prior_log_odds(problem(0.2), {0.0, 0.02, -0.01}), -1.0, 1e-9);
}

TEST_F(PriorOdds, OfAJumpAreTheLessTheBetterOdometryHasShownToBe) {
  const Pose2 there{0.0, 0.2, 0.0};  // two standard deviations of the search
  EXPECT_NEAR(prior_log_odds(problem(0.2), there), -kPriorAgainstJump - 3.0 * std::log(5.0) - 2.0,
              1e-9);
  EXPECT_NEAR(prior_log_odds(problem(0.1), there), -kPriorAgainstJump - 3.0 * std::log(10.0) - 2.0,
              1e-9);
  EXPECT_NEAR(prior_log_odds(problem(1.0), there), -2.0, 1e-9) << "where nothing was learned";
}

TEST_F(PriorOdds, OfAnyJumpAreLimited) {
  const double at_most = kPriorAgainstJump + 3.0 * std::log(5.0) + 12.0;
  EXPECT_GT(prior_log_odds(problem(0.2), {50.0, 0.0, 3.0}), -at_most);
}

TEST_F(PriorOdds, AreUnexpectedBeyondTheQuantileOfWhatOdometryHasShown) {
  EXPECT_FALSE(is_unexpected(problem(0.2), {0.08, 0.0, 0.0}));
  EXPECT_TRUE(is_unexpected(problem(0.2), {0.082, 0.0, 0.0})) << "4.1 standard deviations";
  EXPECT_FALSE(is_unexpected(problem(1.0), {0.082, 0.0, 0.0}));
}

}  // namespace
}  // namespace matchbox_slam
