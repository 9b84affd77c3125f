#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "evaluation/scan_pairs.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"

namespace matchbox_slam {
namespace {

std::vector<LocatedScan> scans_on_a_line(int count) {
  std::vector<LocatedScan> scans(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    scans[static_cast<std::size_t>(i)].world_from_base = {0.1 * i, 5.0, 0.02 * i};
    scans[static_cast<std::size_t>(i)].number = static_cast<std::size_t>(i);
  }
  return scans;
}

std::vector<LocatedScan> simulated_scans() {
  SimulationOptions options;
  options.time.duration = 10.0;
  const World world = make_world("rooms", 2);
  const SimulatedRun run = simulate_run(world, world.route(), options, 2);
  std::vector<LocatedScan> scans;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    scans.push_back({run.scans[i], run.base_from_laser, Pose2{}, run.world_from_base[i], i});
  }
  return scans;
}

/// Answers every problem by throwing.
class ThrowingMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& /*problem*/) const override {
    throw std::runtime_error("out of order");
  }
};

TEST(DrawPairs, KeepsToGapAndLimits) {
  const std::vector<LocatedScan> scans = scans_on_a_line(50);
  PairOptions options;
  options.gap = 7;
  options.error_xy = 0.3;
  options.error_theta = 0.1;
  std::set<std::size_t> references;
  double largest_xy = 0.0;
  double largest_theta = 0.0;
  for (const ScanPair& pair : draw_pairs(scans, options, {}, 5)) {
    ASSERT_EQ(pair.scan, pair.reference + 7);
    ASSERT_LT(pair.scan, scans.size());
    references.insert(pair.reference);
    const Pose2& truth = pair.reference_from_base;
    const Pose2 expected =
        scans[pair.reference].world_from_base.inverse() * scans[pair.scan].world_from_base;
    ASSERT_EQ(truth.x, expected.x);
    ASSERT_EQ(truth.theta, expected.theta);
    largest_xy =
        std::max({largest_xy, std::abs(pair.guess.x - truth.x), std::abs(pair.guess.y - truth.y)});
    largest_theta = std::max(largest_theta, std::abs(pair.guess.theta - truth.theta));
  }
  EXPECT_EQ(references.size(), 43U);  // the first and the last among them
  EXPECT_LE(largest_xy, 0.3);
  EXPECT_GT(largest_xy, 0.29);
  EXPECT_LE(largest_theta, 0.1);
  EXPECT_GT(largest_theta, 0.098);
}

TEST(DrawPairs, SaysHowUncertainTheGuessIs) {
  PairOptions options;
  MotionPriorOptions least;
  least.translation_floor = 0.05;
  least.rotation_floor = 0.01;
  options.error_xy = 0.3;
  options.error_theta = 0.0;
  const ScanPair pair = draw_pairs(scans_on_a_line(50), options, least, 5).front();
  EXPECT_NEAR(pair.guess_covariance(0, 0), 0.03, 1e-12);
  EXPECT_NEAR(pair.guess_covariance(1, 1), 0.03, 1e-12);
  EXPECT_NEAR(pair.guess_covariance(2, 2), 1e-4, 1e-12);
}

TEST(DrawPairs, TellsWhatItIsToldToTell) {
  PairOptions options;
  options.error_xy = 1.0;
  options.error_theta = 0.7;
  options.told_xy = 0.3;
  options.told_theta = 0.09;
  const ScanPair pair = draw_pairs(scans_on_a_line(50), options, {}, 5).front();
  EXPECT_NEAR(pair.guess_covariance(0, 0), 0.03, 1e-12);
  EXPECT_NEAR(pair.guess_covariance(2, 2), 0.0027, 1e-12);
}

TEST(DrawPairs, DrawsErrorsOfEverySizeAsOftenAndToAllSides) {
  PairOptions options;
  options.error_draw = "size";
  options.error_xy = 1.0;
  options.error_theta = 0.5;
  std::vector<double> sizes;
  int ahead = 0;
  int left = 0;
  int turned_left = 0;
  for (const ScanPair& pair : draw_pairs(scans_on_a_line(50), options, {}, 5)) {
    const Eigen::Vector3d error = difference(pair.guess, pair.reference_from_base);
    sizes.push_back(error.head<2>().norm());
    ASSERT_NEAR(std::abs(error.z()), 0.5 * sizes.back(), 1e-12);
    ahead += error.x() > 0.0 ? 1 : 0;
    left += error.y() > 0.0 ? 1 : 0;
    turned_left += error.z() > 0.0 ? 1 : 0;
  }
  std::sort(sizes.begin(), sizes.end());
  ASSERT_EQ(sizes.size(), 1000U);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    ASSERT_NEAR(sizes[i], static_cast<double>(i) / 1000.0, 0.05);
  }
  for (const int count : {ahead, left, turned_left}) {
    EXPECT_NEAR(count, 500, 60);
  }
}

TEST(DrawPairs, DependsOnTheSeedAlone) {
  const std::vector<LocatedScan> scans = scans_on_a_line(300);
  PairOptions few;
  few.pairs = 10;
  PairOptions many;
  many.pairs = 20;
  const std::vector<ScanPair> a = draw_pairs(scans, few, {}, 1);
  const std::vector<ScanPair> b = draw_pairs(scans, many, {}, 1);
  const std::vector<ScanPair> c = draw_pairs(scans, few, {}, 2);
  int same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].reference, b[i].reference);
    EXPECT_EQ(a[i].guess.x, b[i].guess.x);
    EXPECT_EQ(a[i].seed, b[i].seed);
    same += a[i].guess.x == c[i].guess.x ? 1 : 0;
  }
  EXPECT_EQ(same, 0);
}

TEST(DrawPairs, NeedsMoreScansThanTheGap) {
  PairOptions options;
  options.gap = 10;
  EXPECT_THROW((void)draw_pairs(scans_on_a_line(10), options, {}, 1), EvaluationError);
  options.pairs = 3;
  EXPECT_EQ(draw_pairs(scans_on_a_line(11), options, {}, 1).size(), 3U);
}

TEST(DrawPairs, CountsScansOfTheRecordingAcrossHoles) {
  std::vector<LocatedScan> scans = scans_on_a_line(30);
  scans.erase(scans.begin() + 10, scans.begin() + 15);
  PairOptions options;
  options.gap = 3;
  std::set<std::size_t> references;
  for (const ScanPair& pair : draw_pairs(scans, options, {}, 1)) {
    EXPECT_EQ(scans[pair.scan].number, scans[pair.reference].number + 3);
    references.insert(scans[pair.reference].number);
  }
  // 7, 8, 9 and, at the end, 27 to 29 have no partner.
  EXPECT_EQ(references.size(), 30U - 5U - 3U - 3U);
  EXPECT_EQ(references.count(8), 0U);
}

TEST(MatchPairs, FindTheTruthTheSameWithAnyNumberOfThreads) {
  const std::vector<LocatedScan> scans = simulated_scans();
  PairOptions options;
  options.pairs = 20;
  const std::vector<ScanPair> pairs = draw_pairs(scans, options, {}, 1);
  const std::vector<std::shared_ptr<const ScanMatcher>> matchers = {
      std::make_shared<MonteCarloMatcher>()};
  const auto one = match_pairs(scans, pairs, matchers, {}, 1, {});
  const auto three = match_pairs(scans, pairs, matchers, {}, 3, {});
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(one[0].size(), 20U);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const MatchResult& a = one[0][i].result;
    const MatchResult& b = three[0][i].result;
    EXPECT_EQ(a.map_from_base.x, b.map_from_base.x);
    EXPECT_EQ(a.map_from_base.theta, b.map_from_base.theta);
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_NEAR(a.map_from_base.x, pairs[i].reference_from_base.x, 0.005);
    EXPECT_NEAR(a.map_from_base.y, pairs[i].reference_from_base.y, 0.005);
    EXPECT_GT(one[0][i].seconds, 0.0);
  }
}

TEST(MatchPairs, PassOnWhatAMatcherThrows) {
  const std::vector<LocatedScan> scans = simulated_scans();
  const std::vector<ScanPair> pairs = draw_pairs(scans, {}, {}, 1);
  const std::vector<std::shared_ptr<const ScanMatcher>> matchers = {
      std::make_shared<ThrowingMatcher>()};
  EXPECT_THROW((void)match_pairs(scans, pairs, matchers, {}, 2, {}), std::runtime_error);
}

TEST(MatchPairs, NeedNoMorePairsThanThreads) {
  const std::vector<LocatedScan> scans = simulated_scans();
  PairOptions options;
  options.pairs = 2;
  const std::vector<ScanPair> pairs = draw_pairs(scans, options, {}, 1);
  const auto matches =
      match_pairs(scans, pairs, {std::make_shared<MonteCarloMatcher>()}, {}, 1000, {});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_TRUE(matches[0][0].result.accepted());
  EXPECT_TRUE(matches[0][1].result.accepted());
}

TEST(MatchPairs, StopWhenTold) {
  const std::vector<LocatedScan> scans = simulated_scans();
  const std::vector<ScanPair> pairs = draw_pairs(scans, {}, {}, 1);
  std::size_t last = 0;
  const auto matches =
      match_pairs(scans, pairs, {std::make_shared<MonteCarloMatcher>()}, {}, 1, [&](std::size_t n) {
        last = n;
        return n < 5;
      });
  EXPECT_EQ(last, 5U);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].size(), 5U);
}

}  // namespace
}  // namespace matchbox_slam
