// Of tools/truth_options.hpp: what `evaluate` does to the truth before it compares.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "io/real_data.hpp"
#include "io/stata_truth.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/evaluate_program.hpp"

namespace matchbox_slam {
namespace {

class TruthOptionsOfEvaluate : public ::testing::Test {
 protected:
  /// Twice a quarter turn to the left; the truth is of a laser 1 m before the base.
  TruthOptionsOfEvaluate() {
    replace_file(estimate_,
                 "0 0 0 0 0 0 0 1\n"
                 "1 2 0 0 0 0 0.7071067811865476 0.7071067811865476\n"
                 "2 2 3 0 0 0 1 0\n");
    replace_file(truth_, "0,1,0,0\n1000000,2,1,1.5707963267948966\n2000000,1,3,3.1415926535\n");
  }

  [[nodiscard]] nlohmann::json ate(const std::string& options) const {
    const Outcome outcome = run_evaluate("ate " + estimate_ + " --max-gap 1 --align none --json" +
                                         " --truth " + truth_ + " " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    const std::size_t begin = outcome.output.find('{');  // after what it warns of
    EXPECT_NE(begin, std::string::npos) << outcome.output;
    return nlohmann::json::parse(outcome.output.substr(begin), nullptr, false);
  }

  TemporaryFolder folder_;
  std::string estimate_ = folder_ / "estimate.tum";
  std::string truth_ = folder_ / "truth.poses";
};

TEST_F(TruthOptionsOfEvaluate, ReadsTheFormatOfMitStata) {
  const nlohmann::json json = ate("");
  EXPECT_NEAR(json.at("estimates").at(0).at("rmse_m"), 1.0, 1e-9);
  EXPECT_NEAR(json.at("estimates").at(0).at("heading_rmse_rad"), 0.0, 1e-9);
  EXPECT_TRUE(json.at("lever_arm").is_null());
  EXPECT_TRUE(json.at("offset_search").is_null());
  EXPECT_EQ(json.at("time_offset_s"), 0.0);
}

TEST_F(TruthOptionsOfEvaluate, TheLeverArmTakesTheTruthToTheEstimatesBody) {
  const nlohmann::json json = ate("--lever-arm 1");
  EXPECT_NEAR(json.at("estimates").at(0).at("max_m"), 0.0, 1e-9);
  EXPECT_EQ(json.at("lever_arm").at("x_m"), 1.0);
  // One metre ahead and half a metre to the left; turned by 0.1.
  const nlohmann::json whole = ate("--lever-arm 1,0.5,0.1");
  EXPECT_NEAR(whole.at("lever_arm").at("y_m"), 0.5, 1e-12);
  EXPECT_NEAR(whole.at("lever_arm").at("theta_rad"), 0.1, 1e-12);
  EXPECT_NEAR(whole.at("estimates").at(0).at("heading_rmse_rad"), 0.1, 1e-9);
  // truth * lever^-1 is off by (1, 0) - R(-0.1) (1, 0.5), seen from the base.
  EXPECT_NEAR(
      whole.at("estimates").at(0).at("rmse_m"),
      std::hypot(1.0 - std::cos(0.1) - 0.5 * std::sin(0.1), std::sin(0.1) - 0.5 * std::cos(0.1)),
      1e-9);
  EXPECT_NEAR(ate("--lever-arm -1").at("estimates").at(0).at("rmse_m"), 2.0, 1e-9);
}

TEST_F(TruthOptionsOfEvaluate, TheTimeOffsetIsAddedToTheTruthsStamps) {
  const nlohmann::json json = ate("--time-offset 1");
  EXPECT_EQ(json.at("time_offset_s"), 1.0);
  EXPECT_EQ(json.at("estimates").at(0).at("poses"), 2);
  // At 1 s the estimate is at (2, 0), the truth still at (1, 0); at 2 s (2, 3) and (2, 1).
  EXPECT_NEAR(json.at("estimates").at(0).at("max_m"), 2.0, 1e-9);
  EXPECT_NEAR(json.at("estimates").at(0).at("mean_m"), 1.5, 1e-9);
}

TEST_F(TruthOptionsOfEvaluate, TheTableSaysWhatWasDoneToTheTruth) {
  const std::string command = "ate " + estimate_ + " --max-gap 1 --truth " + truth_;
  const std::string moved = run_evaluate(command + " --lever-arm 1,0.5 --time-offset -0.25").output;
  EXPECT_TRUE(contains(moved, "at x 1.000 m, y 0.500 m, theta 0.0000 rad")) << moved;
  EXPECT_TRUE(contains(moved, "Truth's stamps - 0.250 s")) << moved;
  const std::string tiny = run_evaluate(command + " --time-offset -1e-19").output;
  EXPECT_TRUE(contains(tiny, "Truth's stamps + 0.000 s")) << tiny;
  const std::string plain = run_evaluate(command).output;
  EXPECT_FALSE(contains(plain, "Truth moved")) << plain;
  EXPECT_FALSE(contains(plain, "Truth's stamps")) << plain;
}

TEST_F(TruthOptionsOfEvaluate, WrongUsageExitsWithTwoAndOneLine) {
  for (const std::string options :
       {"--lever-arm one", "--lever-arm 1,2,3,4", "--lever-arm 1,,2", "--lever-arm nan",
        "--time-offset soon", "--time-offset nan", "--time-offset 1e30", "--max-gap inf",
        "--max-gap nan", "--find-offset --time-offset 1", "--offset-range 10",
        "--find-offset --offset-range 0", "--find-offset --offset-range 1e9"}) {
    const Outcome outcome = run_evaluate("ate " + estimate_ + " --truth " + truth_ + " " + options);
    EXPECT_EQ(outcome.exit_code, 2) << options << ": " << outcome.output;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
  }
}

TEST_F(TruthOptionsOfEvaluate, AnOffsetThatCannotBeFoundIsAnErrorOfOneLine) {
  std::string rest;
  for (int i = 0; i < 100; ++i) {
    rest += std::to_string(i) + "00000,1,2,3\n";
  }
  replace_file(truth_, rest);
  const Outcome outcome = run_evaluate("rpe " + estimate_ + " --find-offset --truth " + truth_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "no clock offset found")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, estimate_)) << outcome.output;
}

/// Makes of the laser's true poses what a SLAM system in the other clock would write of the base.
TEST_F(TruthOptionsOfEvaluate, FindsTheOffsetOfMitStataAndComparesWithIt) {
  const std::string path = real_data("mit_stata_2012-01-25-12-33-29_part1_floor2.gt.laser.poses");
  MATCHBOX_SKIP_WITHOUT(path);
  std::vector<StampedPose2> poses = parse_stata_truth(read_file(path), path).poses();
  for (StampedPose2& stamped : poses) {
    stamped = {stamped.stamp + 82.2, Pose2{4.0, 5.0, 1.0} * stamped.pose * Pose2{-0.275, 0.0, 0.0}};
  }
  write_tum(estimate_, Trajectory(poses));
  const std::string options = estimate_ + " --truth " + path + " --lever-arm 0.275 --find-offset";
  const Outcome printed = run_evaluate("ate " + options);
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_TRUE(contains(printed.output, "\n82.20     0.0000   ")) << printed.output;
  // At -120 s less than half of the 200 s overlap.
  EXPECT_FALSE(contains(printed.output, "from -120 to")) << printed.output;
  EXPECT_TRUE(contains(printed.output, " to 120 s, where enough overlaps")) << printed.output;
  EXPECT_TRUE(contains(printed.output, "Truth's stamps + 82.200 s\n")) << printed.output;
  EXPECT_LT(line_count(printed.output), 40U);
  const auto json = nlohmann::json::parse(run_evaluate("ate --json " + options).output);
  EXPECT_NEAR(json.at("time_offset_s"), 82.2, 0.001);
  EXPECT_LT(json.at("estimates").at(0).at("rmse_m"), 0.0005);
  EXPECT_GE(json.at("estimates").at(0).at("poses"), 3998);
  EXPECT_EQ(json.at("offset_search").at("estimate"), estimate_);
  EXPECT_GT(json.at("offset_search").at("curve").size(), 500U);
}

}  // namespace
}  // namespace matchbox_slam
