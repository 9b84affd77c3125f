// Of tools/evaluate_rpe.hpp: `evaluate rpe` as a user runs it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/evaluate_program.hpp"

namespace matchbox_slam {
namespace {

class EvaluateRpe : public ::testing::Test {
 protected:
  /// Three metres in 1.5 s; the estimate takes each step for 1.1 m.
  EvaluateRpe() {
    replace_file(truth_,
                 "0 0 0 0 0 0 0 1\n0.5 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n1.5 3 0 0 0 0 0 1\n");
    replace_file(estimate_,
                 "0 7 0 0 0 0 0 1\n0.5 8.1 0 0 0 0 0 1\n1 9.2 0 0 0 0 0 1\n1.5 10.3 0 0 0 0 0 1\n"
                 "9 0 0 0 0 0 0 1\n");
  }

  TemporaryFolder folder_;
  std::string truth_ = folder_ / "truth.tum";
  std::string estimate_ = folder_ / "estimate.tum";
  std::string compared_ = " --truth " + truth_;
};

TEST_F(EvaluateRpe, PrintsABlockAMeasureWithARowAnEstimate) {
  const Outcome outcome = run_evaluate("rpe " + estimate_ + " " + truth_ + compared_);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(line_count(outcome.output), 3U + 6U * 4U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "\nper 5 m ")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "      3  0.1000  0.1000")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "      2  0.2000  0.2000")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "      3  0.0000  0.0000")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "      0       –       –")) << outcome.output;
}

TEST_F(EvaluateRpe, PrintsJsonWithNullForAMeasureWithoutPairs) {
  const Outcome outcome = run_evaluate("rpe --json " + estimate_ + compared_);
  EXPECT_EQ(outcome.exit_code, 0);
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("metric"), "rpe");
  EXPECT_EQ(json.at("truth"), truth_);
  const auto& estimate = json.at("estimates").at(0);
  EXPECT_EQ(estimate.at("estimate"), estimate_);
  EXPECT_EQ(estimate.at("without_truth"), 1);
  const auto& measures = estimate.at("measures");
  EXPECT_EQ(measures.size(), 6U);
  EXPECT_EQ(measures.at("per_scan").at("pairs"), 3);
  EXPECT_NEAR(measures.at("per_scan").at("translation_m").at("median"), 0.1, 1e-9);
  EXPECT_NEAR(measures.at("per_1_s").at("translation_m").at("rmse"), 0.2, 1e-9);
  EXPECT_NEAR(measures.at("per_1_m").at("translation_m").at("max"), 0.1, 1e-9);
  EXPECT_NEAR(measures.at("per_1_m").at("rotation_rad").at("p95"), 0.0, 1e-9);
  EXPECT_TRUE(measures.at("per_5_m").is_null());
  EXPECT_TRUE(measures.at("per_10_m").is_null());
  EXPECT_TRUE(measures.at("per_1_rad").is_null());
}

TEST_F(EvaluateRpe, NoPairAtAllIsAnError) {
  replace_file(estimate_, "0.2 0 0 0 0 0 0 1\n");
  const Outcome outcome = run_evaluate("rpe " + estimate_ + compared_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "make a pair")) << outcome.output;
}

}  // namespace
}  // namespace matchbox_slam
