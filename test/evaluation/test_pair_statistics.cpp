#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "evaluation/pair_statistics.hpp"

namespace matchbox_slam {
namespace {

ScanPair pair_at(const Pose2& truth) {
  ScanPair pair;
  pair.reference_from_base = truth;
  return pair;
}

PairMatch match_at(const Pose2& pose, MatchStatus status = MatchStatus::kAccepted) {
  PairMatch match;
  match.result.map_from_base = pose;
  match.result.status = status;
  match.result.covariance = Eigen::Vector3d(1e-4, 4e-4, 1e-4).asDiagonal();
  match.seconds = 0.002;
  return match;
}

TEST(PairStatistics, OfThreePairsByHand) {
  const std::vector<ScanPair> pairs = {pair_at({1.0, 0.0, 0.0}), pair_at({1.0, 0.0, 3.14}),
                                       pair_at({1.0, 0.0, 0.0})};
  const std::vector<PairMatch> matches = {
      match_at({1.01, 0.0, 0.0}),                                  // 1 cm: a success
      match_at({1.0, 0.02, -3.14}),                                // 2 cm, 3.2 mrad: a success
      match_at({1.0, 0.3, 0.0}, MatchStatus::kRejectedLowScore)};  // 30 cm, rejected
  const PairStatistics statistics = summarize_pairs(pairs, matches, {});
  EXPECT_EQ(statistics.pairs, 3U);
  EXPECT_EQ(statistics.accepted, 2U);
  EXPECT_EQ(statistics.successes, 2U);
  EXPECT_DOUBLE_EQ(statistics.success_rate(), 2.0 / 3.0);
  EXPECT_NEAR(statistics.translation.median, 0.02, 1e-12);
  EXPECT_NEAR(statistics.translation.max, 0.3, 1e-12);
  EXPECT_NEAR(statistics.heading.max, 2.0 * (kPi - 3.14), 1e-12);
  EXPECT_NEAR(statistics.seconds.mean, 0.002, 1e-12);
  // 0.01^2 / 1e-4 = 1 and 0.02^2 / 4e-4 + 0.0032^2 / 1e-4 = 1.1.
  const double second = 1.0 + std::pow(2.0 * (kPi - 3.14), 2) / 1e-4;
  ASSERT_TRUE(statistics.covariance);
  EXPECT_NEAR(statistics.covariance->mean_nees, 0.5 * (1.0 + second), 1e-9);
  EXPECT_FALSE(statistics.known_world_bound);
}

TEST(PairStatistics, TellOfTheSearchesAlone) {
  const std::vector<ScanPair> pairs(3, pair_at({1.0, 0.0, 3.14}));
  std::vector<PairMatch> matches = {match_at({1.0, 0.0, 3.14}), match_at({1.0, 0.001, 3.14}),
                                    match_at({1.0, 0.015, 3.14}, MatchStatus::kRejectedLowScore)};
  matches[0].result.refined_by = {0.03, -0.04, 0.0};    // from 5 cm off: no success
  matches[1].result.refined_by = {0.0, 0.001, -0.005};  // from 5 mrad off, beyond half a circle
  const PairStatistics statistics = summarize_pairs(pairs, matches, {});
  EXPECT_EQ(statistics.successes, 2U);
  EXPECT_EQ(statistics.search.successes, 1U);
  EXPECT_DOUBLE_EQ(statistics.search_success_rate(), 1.0 / 3.0);
  EXPECT_NEAR(statistics.search.translation.max, 0.05, 1e-12);
  EXPECT_NEAR(statistics.search.translation.median, 0.015, 1e-12);
  EXPECT_NEAR(statistics.search.heading.max, 0.005, 1e-12);
}

TEST(PairStatistics, CompareTheErrorWithTheBoundAlongTheAxesOfTheBase) {
  // The base looks along y of the reference, so an error along y is one along its own x, of which
  // the scan tells with a standard deviation of 1 mm.
  const std::vector<ScanPair> pairs = {pair_at({0.0, 0.0, kPi / 2.0})};
  const std::vector<PairMatch> matches = {match_at({0.0, 0.003, kPi / 2.0})};
  const Eigen::Matrix3d information = Eigen::Vector3d(1e6, 1e2, 1e6).asDiagonal();
  const PairStatistics statistics =
      summarize_pairs(pairs, matches, {{information}, {0.25 * information}});
  ASSERT_TRUE(statistics.known_world_bound);
  ASSERT_TRUE(statistics.unknown_walls_bound);
  EXPECT_NEAR(statistics.known_world_bound->ratio.value(), std::sqrt(9.0 / 3.0), 1e-9);
  EXPECT_NEAR(statistics.unknown_walls_bound->ratio.value(), 0.5 * std::sqrt(9.0 / 3.0), 1e-9);
  EXPECT_NEAR(statistics.unknown_walls_bound->heading, 2e-3, 1e-9);
  EXPECT_NEAR(statistics.known_world_bound->translation, std::sqrt(1e-6 + 1e-2), 1e-9);
  EXPECT_NEAR(statistics.known_world_bound->heading, 1e-3, 1e-9);
}

TEST(PairStatistics, TellTheRatioAlsoWhereADirectionIsOpen) {
  const std::vector<ScanPair> pairs = {pair_at({})};
  const std::vector<PairMatch> matches = {match_at({0.01, 0.002, 0.0})};
  const Eigen::Matrix3d information = Eigen::Vector3d(0.0, 1e6, 1e6).asDiagonal();
  const PairStatistics statistics = summarize_pairs(pairs, matches, {{information}, {}});
  ASSERT_TRUE(statistics.known_world_bound);
  EXPECT_NEAR(statistics.known_world_bound->ratio.value(), std::sqrt(4.0 / 2.0),
              1e-9);  // of two coordinates
  EXPECT_TRUE(std::isinf(statistics.known_world_bound->translation));
}

TEST(PairStatistics, LeaveOutOfTheBoundWhatFailed) {
  const std::vector<ScanPair> pairs = {pair_at({}), pair_at({})};
  const std::vector<PairMatch> matches = {match_at({0.001, 0.0, 0.0}), match_at({0.5, 0.0, 0.0})};
  const Eigen::Matrix3d information = Eigen::Matrix3d::Identity() * 1e6;
  const PairStatistics statistics =
      summarize_pairs(pairs, matches, {{information, information}, {}});
  EXPECT_NEAR(statistics.known_world_bound->ratio.value(), std::sqrt(1.0 / 3.0), 1e-9);
}

TEST(PairStatistics, TellTheBoundAlsoOfAMatcherWithoutSuccess) {
  const Eigen::Matrix3d information = Eigen::Matrix3d::Identity() * 1e6;
  const PairStatistics statistics =
      summarize_pairs({pair_at({})}, {match_at({0.5, 0.0, 0.0})}, {{information}, {}});
  ASSERT_TRUE(statistics.known_world_bound);
  EXPECT_FALSE(statistics.known_world_bound->ratio);
  EXPECT_NEAR(statistics.known_world_bound->heading, 1e-3, 1e-9);
}

TEST(PairStatistics, LeaveOutCovariancesThatAreNone) {
  std::vector<PairMatch> matches(3, match_at({0.01, 0.0, 0.0}));
  matches[0].result.covariance.setZero();
  matches[1].result.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const PairStatistics statistics =
      summarize_pairs(std::vector<ScanPair>(3, pair_at({})), matches, {});
  ASSERT_TRUE(statistics.covariance);
  EXPECT_EQ(statistics.covariance->matches, 1U);
  EXPECT_NEAR(statistics.covariance->mean_nees, 1.0, 1e-9);
}

TEST(PairStatistics, NeedAMatchForEveryPair) {
  EXPECT_THROW((void)summarize_pairs({}, {}, {}), std::invalid_argument);
  EXPECT_THROW((void)summarize_pairs({pair_at({})}, {}, {}), std::invalid_argument);
  EXPECT_THROW((void)summarize_pairs({pair_at({}), pair_at({})}, {match_at({}), match_at({})},
                                     {{Eigen::Matrix3d::Identity()}, {}}),
               std::invalid_argument);
  EXPECT_THROW((void)summarize_pairs({pair_at({}), pair_at({})}, {match_at({}), match_at({})},
                                     {{}, {Eigen::Matrix3d::Identity()}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace matchbox_slam
