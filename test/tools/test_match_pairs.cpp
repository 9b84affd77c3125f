// Of tools/pair_matching.hpp: match_pairs as a user runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "common/interrupted.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/pair_matching.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

using nlohmann::json;

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) {
    parts.push_back(part);
  }
  return parts;
}

class MatchPairsProgram : public testing::Test {
 protected:
  /// A short drive, for what does not depend on accuracy.
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    simulate("short", "--world rooms --seed 3 --duration 12 --beams 300");
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static void simulate(const std::string& name, const std::string& options) {
    const Outcome outcome =
        run_command(MATCHBOX_SIMULATE, options + " --bag " + (*folder_ / (name + ".bag")) +
                                           " --truth " + (*folder_ / (name + ".tum")));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }

  /// Runs the program on a simulated recording; results go to a folder `out`.
  static Outcome match(const std::string& name, const std::string& out,
                       const std::string& options = "") {
    return run_command(MATCHBOX_MATCH_PAIRS, (*folder_ / (name + ".bag")) + " --truth " +
                                                 (*folder_ / (name + ".tum")) + " --out " +
                                                 (*folder_ / out) + " " + options);
  }

  static json summary(const std::string& out) {
    return json::parse(read_file(*folder_ / (out + "/summary.json")));
  }

  /// The lines of pairs.csv, in columns.
  static std::vector<std::vector<std::string>> rows(const std::string& out) {
    std::vector<std::vector<std::string>> rows;
    for (const std::string& line : split(read_file(*folder_ / (out + "/pairs.csv")), '\n')) {
      rows.push_back(split(line, ','));
    }
    return rows;
  }

  static void expect_one_line(int exit_code, const Outcome& outcome, const std::string& word) {
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, word)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }

  static std::unique_ptr<TemporaryFolder> folder_;
};

std::unique_ptr<TemporaryFolder> MatchPairsProgram::folder_;

TEST_F(MatchPairsProgram, WritesALineForEveryMatcherAndPair) {
  const Outcome outcome =
      match("short", "table", "--matcher monte_carlo --matcher odometry_only --pairs 30 --gap 5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "| monte_carlo |")) << outcome.output;
  const auto table = rows("table");
  ASSERT_EQ(table.size(), 61U);
  EXPECT_EQ(table[0],
            split("matcher,reference_stamp,scan_stamp,guess_x,guess_y,guess_theta,x,y,theta,"
                  "search_x,search_y,search_theta,var_x,var_y,var_theta,status,time_us",
                  ','));
  for (std::size_t i = 1; i <= 30; ++i) {
    EXPECT_EQ(table[i].size(), 17U);
    EXPECT_EQ(table[i][0], "monte_carlo");
    EXPECT_EQ(table[i + 30][0], "odometry_only");
    for (const std::size_t column : {1U, 2U, 3U, 4U, 5U}) {  // the same pairs for both
      EXPECT_EQ(table[i][column], table[i + 30][column]);
    }
    EXPECT_NEAR(std::stod(table[i][2]) - std::stod(table[i][1]), 0.25, 1e-6);
    EXPECT_EQ(table[i + 30][6], table[i + 30][3]);  // odometry believes the guess
  }
}

TEST_F(MatchPairsProgram, TellsWhatWasMatchedAndByWhat) {
  ASSERT_EQ(match("short", "told", "--matcher odometry_only --pairs 10 --gap 5").exit_code, 0);
  const json told = summary("told");
  EXPECT_EQ(told["beams"], 300);
  EXPECT_NEAR(told["gap_s"].get<double>(), 0.25, 1e-6);
  EXPECT_GT(told["reach_m"].get<double>(), 1.0);
  EXPECT_LT(told["reach_m"].get<double>(), 31.0);  // the laser's range, and its place on the base
  EXPECT_FALSE(told["commit"].get<std::string>().empty());
  EXPECT_EQ(told["date"].get<std::string>().size(), 10U);
  EXPECT_GT(told["machine"]["cores"], 0);
}

TEST_F(MatchPairsProgram, TellsTheSearchesOwnAnswersBesideTheRefinedOnes) {
  const std::string matchers = "--matcher monte_carlo --matcher olson --matcher hough --pairs 30 ";
  std::string search_only;
  for (const std::string name : {"monte_carlo", "olson", "hough"}) {
    search_only += " --set " + name + "/refine_iterations=0";
  }
  ASSERT_EQ(match("short", "both", matchers).exit_code, 0);
  ASSERT_EQ(match("short", "raw", matchers + search_only).exit_code, 0);
  const auto both = rows("both");
  const auto raw = rows("raw");
  ASSERT_EQ(both.size(), 91U);
  for (std::size_t i = 1; i < both.size(); ++i) {
    for (const std::size_t column : {9U, 10U, 11U}) {  // what the search alone answers
      EXPECT_EQ(both[i][column], raw[i][column]) << both[i][0];
      EXPECT_EQ(raw[i][column], raw[i][column - 3]) << "there is nothing but the search";
    }
  }
  for (const json& matcher : summary("both").at("matchers")) {
    const json& search = matcher.at("search");
    EXPECT_GT(search.at("translation_mm").at("median"),
              2.0 * matcher.at("translation_mm").at("median").get<double>());
    EXPECT_LE(search.at("success_rate"), matcher.at("success_rate"));
    EXPECT_GT(search.at("success_rate"), 0.5);
  }
}

TEST_F(MatchPairsProgram, TellsNoBoundWhereOutliersAre) {
  simulate("outliers", "--world rooms --seed 3 --duration 12 --beams 300 --outliers 0.2");
  const Outcome outcome = match("outliers", "outliers", "--pairs 20 --matcher olson");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_FALSE(contains(outcome.output, "no bound is told")) << outcome.output;
  EXPECT_TRUE(summary("outliers").at("matchers").at(0).at("cramer_rao").is_null());
}

TEST_F(MatchPairsProgram, DrawsAndTellsErrorsAsAsked) {
  ASSERT_EQ(match("short", "sizes",
                  "--pairs 400 --matcher odometry_only --error-draw size --error-xy 1 "
                  "--error-theta 0.5 --told-xy 0.2 --told-theta 0.1")
                .exit_code,
            0);
  const json told = summary("sizes");
  EXPECT_EQ(told.at("error_draw"), "size");
  EXPECT_EQ(told.at("told_xy_m"), 0.2);
  EXPECT_EQ(told.at("told_theta_rad"), 0.1);
  const json matcher = told.at("matchers").at(0);
  EXPECT_NEAR(matcher.at("translation_mm").at("median"), 500.0, 60.0);
  EXPECT_NEAR(matcher.at("translation_mm").at("max"), 1000.0, 20.0);
  EXPECT_NEAR(matcher.at("heading_mrad").at("max"), 500.0, 10.0);
  EXPECT_GT(matcher.at("nees_mean"), 20.0) << "what is told is less than what is true";
}

TEST_F(MatchPairsProgram, MeasuresTheErrorOfTheGuessRight) {
  // The odometry-only matcher's errors are the errors of the guess, which are known.
  ASSERT_EQ(match("short", "guess", "--matcher odometry_only").exit_code, 0);
  const json matcher = summary("guess").at("matchers").at(0);
  EXPECT_EQ(matcher.at("matcher"), "odometry_only");
  EXPECT_EQ(matcher.at("pairs"), 1000);
  EXPECT_NEAR(matcher.at("heading_mrad").at("median"), 100.0, 8.0);
  EXPECT_NEAR(matcher.at("heading_mrad").at("p95"), 190.0, 4.0);
  EXPECT_NEAR(matcher.at("translation_mm").at("rmse"), 200.0 * std::sqrt(2.0 / 3.0), 6.0);
  EXPECT_NEAR(matcher.at("nees_mean"), 3.0, 0.15);  // the prior tells the truth about the guess
  EXPECT_LT(matcher.at("success_rate"), 0.01);
}

TEST_F(MatchPairsProgram, GivesTheSameWithAnyNumberOfThreads) {
  ASSERT_EQ(match("short", "one", "--pairs 40 --threads 1").exit_code, 0);
  ASSERT_EQ(match("short", "two", "--pairs 40 --threads 2").exit_code, 0);
  auto one = rows("one");
  auto two = rows("two");
  ASSERT_EQ(one.size(), 41U);
  ASSERT_EQ(two.size(), 41U);
  for (std::size_t i = 1; i < one.size(); ++i) {
    one[i].pop_back();  // the time
    two[i].pop_back();
    EXPECT_EQ(one[i], two[i]);
  }
}

TEST_F(MatchPairsProgram, TakesTheMatchersOptions) {
  ASSERT_EQ(match("short", "set", "--pairs 5 --matcher monte_carlo --set monte_carlo/max_tries=77")
                .exit_code,
            0);
  EXPECT_EQ(summary("set").at("matchers").at(0).at("configuration").at("monte_carlo/max_tries"),
            77);
}

TEST_F(MatchPairsProgram, DrawsHoughDomainsForDebugging) {
  const std::string debug = *folder_ / "debug";
  const auto draw = [&](const std::string& folder) {
    return match("short", "drawn", "--matcher odometry_only --pairs 30 --debug " + folder);
  };
  ASSERT_EQ(draw(debug).exit_code, 0);
  for (int i = 0; i < 20; ++i) {
    const std::string picture = read_file(debug + "/hough_" + std::to_string(i) + ".png");
    EXPECT_EQ(picture.substr(1, 3), "PNG") << i;
  }
  EXPECT_FALSE(std::filesystem::exists(debug + "/hough_20.png")) << "the first ones only";
  replace_file(*folder_ / "taken", "");
  expect_one_line(1, draw(*folder_ / "taken/debug"), "taken");
}

TEST_F(MatchPairsProgram, RefusesWrongUsageInOneLine) {
  expect_one_line(2, match("short", "no", "--matcher nobody"), "nobody");
  expect_one_line(2, match("short", "no", "--matcher monte_carlo --matcher monte_carlo"), "twice");
  expect_one_line(2, match("short", "no", "--pairs 0"), "pairs");
  expect_one_line(2, match("short", "no", "--error-xy -1"), "error_xy");
  expect_one_line(
      2,
      run_command(MATCHBOX_MATCH_PAIRS, "missing.bag --truth " + (*folder_ / "short.tum") +
                                            " --out " + (*folder_ / "no")),
      "missing.bag");
  expect_one_line(2, run_command(MATCHBOX_MATCH_PAIRS, "a.bag --out x"), "--truth");
}

TEST_F(MatchPairsProgram, AnInterruptEndsItInGoodOrder) {
  const Outcome outcome = run_interrupted(
      MATCHBOX_MATCH_PAIRS, (*folder_ / "short.bag") + " --truth " + (*folder_ / "short.tum") +
                                " --quiet --out " + (*folder_ / "interrupted"));
  expect_one_line(0, outcome, "interrupted before the first scan was used; nothing is written");
  EXPECT_TRUE(std::filesystem::is_empty(*folder_ / "interrupted"));
}

TEST_F(MatchPairsProgram, InterruptedItWritesThePairsThatAreDone) {
  (void)match("short", "whole", "--pairs 20");
  MatchPairsRequest request;
  request.recording.bags = {*folder_ / "short.bag"};
  request.truth = *folder_ / "short.tum";
  request.out = *folder_ / "part";
  request.pairs.pairs = 20;
  bool interrupted = false;
  const auto ignore = [](const std::string& /*line*/) {};
  EXPECT_EQ(error_text<std::runtime_error>([&] {
              try {
                match_pairs(request, {ignore, ignore,
                                      [&](double /*done*/, const std::string& text) {
                                        interrupted = interrupted || text == "7 pairs";
                                      },
                                      [&] { return interrupted; }});
              } catch (const Interrupted&) {
                ADD_FAILURE() << "with which it would exit 0";
                throw;
              }
            }),
            "interrupted; the results cover 7 of 20 pairs");
  EXPECT_EQ(summary("part")["pairs"], 7);
  const auto part = rows("part");
  const auto whole = rows("whole");
  ASSERT_EQ(part.size(), 8U) << "with the heading";
  for (std::size_t i = 0; i < part.size(); ++i) {
    EXPECT_EQ(part[i][3], whole[i][3]) << "x of the guess";
    EXPECT_EQ(part[i][6], whole[i][6]) << "x of the answer";
  }
}

TEST_F(MatchPairsProgram, TellsWhatIsWrongWithTheTruth) {
  const std::string bag = *folder_ / "short.bag";
  const std::string out = " --quiet --out " + (*folder_ / "no");
  expect_one_line(2, run_command(MATCHBOX_MATCH_PAIRS, bag + " --truth /nowhere.tum" + out),
                  "/nowhere.tum");
  replace_file(*folder_ / "late.tum", "5 0 0 0 0 0 0 1\n");
  expect_one_line(
      1, run_command(MATCHBOX_MATCH_PAIRS, bag + " --truth " + (*folder_ / "late.tum") + out),
      "clock");
  replace_file(*folder_ / "empty.tum", "");
  expect_one_line(
      1, run_command(MATCHBOX_MATCH_PAIRS, bag + " --truth " + (*folder_ / "empty.tum") + out),
      "no poses");
  expect_one_line(1, match("short", "no", "--quiet --gap 100000"), "apart");
}

TEST_F(MatchPairsProgram, FindsTheTruthOfRareScansInAnotherClock) {
  simulate("rare", "--world rooms --seed 3 --duration 60 --beams 300 --scan-rate 1.7");
  ASSERT_EQ(match("rare", "rare", "--pairs 20 --gap 1").exit_code, 0);
  EXPECT_EQ(summary("rare").at("scans_with_truth"), summary("rare").at("scans"));
  simulate("clock", "--world rooms --seed 3 --duration 60 --beams 300 --clock-offset 82.2");
  ASSERT_EQ(match("clock", "clock", "--pairs 20 --set scan_time_offset=auto").exit_code, 0);
  EXPECT_GT(summary("clock").at("scans_with_truth"), 1190);
  EXPECT_GE(summary("clock").at("matchers").at(0).at("success_rate"), 0.95);
}

TEST_F(MatchPairsProgram, TakesTheSeedFromEitherPlace) {
  ASSERT_EQ(match("short", "flag", "--pairs 5 --seed 7").exit_code, 0);
  ASSERT_EQ(match("short", "key", "--pairs 5 --set seed=7").exit_code, 0);
  EXPECT_EQ(rows("flag")[1][3], rows("key")[1][3]);
  EXPECT_EQ(summary("key").at("seed"), 7);
}

struct Accuracy {
  const char* name;
  const char* world;
  const char* pairs;
  double median_mm;
  double median_mrad;
  double error_to_bound;  ///< 0: there is no bound without noise
  double bound_mrad;
};

std::ostream& operator<<(std::ostream& stream, const Accuracy& accuracy) {
  return stream << accuracy.name;
}

class MatcherOnPairs : public MatchPairsProgram, public testing::WithParamInterface<Accuracy> {};

// The bounds are 1.5 times what the worse of the matchers is measured at without noise; with noise
// they are what is measured without straight walls, and 3 times the bound. All are below what is
// asked for: 1 mm and 0.5 mrad. Both end with the same refinement.
TEST_P(MatcherOnPairs, FindsTheTruth) {
  const Accuracy& bound = GetParam();
  simulate(bound.name, bound.world);
  const Outcome outcome = match(
      bound.name, bound.name, std::string(bound.pairs) + " --matcher monte_carlo --matcher olson");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const json& matcher : summary(bound.name).at("matchers")) {
    SCOPED_TRACE(matcher.at("matcher").get<std::string>());
    EXPECT_EQ(matcher.at("pairs"), 1000);
    EXPECT_GE(matcher.at("success_rate"), 0.995);
    EXPECT_LE(matcher.at("translation_mm").at("median"), bound.median_mm);
    EXPECT_LE(matcher.at("heading_mrad").at("median"), bound.median_mrad);
    const bool has_bound = !matcher.at("cramer_rao").is_null();
    EXPECT_EQ(has_bound, bound.error_to_bound > 0.0);
    if (has_bound) {
      EXPECT_GE(matcher.at("nees_mean"), 2.0);
      EXPECT_LE(matcher.at("nees_mean"), 4.5);
      EXPECT_GE(matcher.at("cramer_rao").at("error_to_bound"), 1.0);
      EXPECT_LE(matcher.at("cramer_rao").at("error_to_bound"), bound.error_to_bound);
      EXPECT_NEAR(matcher.at("cramer_rao").at("bound_heading_mrad"), bound.bound_mrad,
                  0.1 * bound.bound_mrad);
      EXPECT_GE(matcher.at("cramer_rao_unknown_walls").at("error_to_bound"), 1.0);
      EXPECT_GT(matcher.at("cramer_rao_unknown_walls").at("bound_heading_mrad"),
                1.3 * bound.bound_mrad);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Worlds, MatcherOnPairs,
    testing::Values(
        Accuracy{"rooms", "--world rooms --range-noise 0 --dropout 0", "--threads 2", 0.075, 0.02,
                 0.0, 0.0},
        Accuracy{"random", "--world random --range-noise 0 --dropout 0", "--threads 2", 0.2, 0.065,
                 0.0, 0.0},
        Accuracy{"rooms_good_guess", "--world rooms --range-noise 0 --dropout 0",
                 "--threads 2 --error-xy 0 --error-theta 0", 0.075, 0.02, 0.0, 0.0},
        Accuracy{"random_good_guess", "--world random --range-noise 0 --dropout 0",
                 "--threads 2 --error-xy 0 --error-theta 0", 0.2, 0.065, 0.0, 0.0},
        Accuracy{"rooms_noisy", "--world rooms", "--threads 2", 0.85, 0.105, 4.8, 0.067},
        Accuracy{"random_noisy", "--world random", "--threads 2", 0.88, 0.0915, 7.5, 0.031}));

// With the guess off by up to 1 m and 45 degrees.
TEST_F(MatchPairsProgram, HoughFindsTheTranslationToo) {
  struct World {
    const char* name;
    const char* options;
    double success;
    double median_mm;
    double median_mrad;
  };
  for (const World& world :
       {World{"rooms", "--world rooms", 0.99, 0.85, 0.105},
        World{"rooms0", "--world rooms --range-noise 0 --dropout 0", 0.99, 0.075, 0.02},
        World{"random", "--world random", 0.95, 0.88, 0.0915}}) {
    SCOPED_TRACE(world.name);
    simulate(world.name, world.options);
    const Outcome outcome =
        match(world.name, world.name, "--pairs 500 --threads 2 --matcher hough");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    const json hough = summary(world.name).at("matchers").at(0);
    EXPECT_EQ(hough.at("pairs"), 500);
    EXPECT_GE(hough.at("success_rate"), world.success);
    EXPECT_LE(hough.at("translation_mm").at("median"), world.median_mm);
    EXPECT_LE(hough.at("heading_mrad").at("median"), world.median_mrad);
    if (std::string(world.name) == "rooms") {
      EXPECT_GE(hough.at("nees_mean"), 2.0);
      EXPECT_LE(hough.at("nees_mean"), 4.5);
    }
  }
}

TEST_F(MatchPairsProgram, OlsonFindsTheTruthFromFar) {
  simulate("far", "--world rooms");
  ASSERT_EQ(match("far", "far",
                  "--pairs 300 --threads 2 --matcher olson --error-xy 1 "
                  "--error-theta 0.7854")
                .exit_code,
            0);
  EXPECT_GE(summary("far").at("matchers").at(0).at("success_rate"), 0.98);
}

}  // namespace
}  // namespace matchbox_slam
