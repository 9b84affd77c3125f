// Of tools/evaluate_relations.hpp: `evaluate relations` as a user runs it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "common/error_text.hpp"
#include "io/real_data.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/evaluate_program.hpp"

namespace matchbox_slam {
namespace {

class EvaluateRelations : public ::testing::Test {
 protected:
  /// The relations say that two steps of 1 m were 1.5 m and 1 m; the third has no pose nearby.
  EvaluateRelations() {
    replace_file(estimate_, "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
    replace_file(relations_, "0 1 1.5 0 0 0 0 0\n1 2 1 0 0 0 0 0.5\n1 5 0 0 0 0 0 0\n");
  }

  TemporaryFolder folder_;
  std::string estimate_ = folder_ / "estimate.tum";
  std::string relations_ = folder_ / "a.relations";
  std::string compared_ = " --relations " + relations_;
};

TEST_F(EvaluateRelations, PrintsATableInMetresAndDegrees) {
  const Outcome outcome = run_evaluate("relations " + estimate_ + " " + estimate_ + compared_);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(line_count(outcome.output), 7U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "the 3 relations")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "0.2500 ± 0.2500  0.5000  0.1250 ± 0.1250"))
      << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "14.324 ± 14.324   28.648")) << outcome.output;
}

TEST_F(EvaluateRelations, PrintsJson) {
  const auto json =
      nlohmann::json::parse(run_evaluate("relations --json " + estimate_ + compared_).output);
  const auto expected = nlohmann::json::parse(R"({
    "metric": "relations", "relations_file": "", "relations": 3, "odometry": null,
    "estimates": [{"estimate": "", "usable": 2, "unusable": {"no_estimate_nearby": 1}, "extrapolated": 0,
      "translation_m": {"mean": 0.25, "std": 0.25, "max": 0.5},
      "translation_squared_m2": {"mean": 0.125, "std": 0.125},
      "rotation_rad": {"mean": 0.25, "std": 0.25, "max": 0.5},
      "rotation_squared_rad2": {"mean": 0.125, "std": 0.125}}]})");
  auto named = expected;
  named["relations_file"] = relations_;
  named["estimates"][0]["estimate"] = estimate_;
  EXPECT_EQ(json, named) << json.dump(2);
}

TEST_F(EvaluateRelations, OdometryDecidesWhatIsUsable) {
  replace_file(folder_ / "odometry.tum", "0 0 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n5 2 0 0 0 0 0 1\n");
  const std::string odometry = " --odometry " + (folder_ / "odometry.tum");
  const Outcome outcome = run_evaluate("relations --json " + estimate_ + compared_ + odometry);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;  // none is near 1 s
  replace_file(relations_, "0 5 2 0 0 0 0 0\n0 1 1 0 0 0 0 0\n");
  const auto json = nlohmann::json::parse(
      run_evaluate("relations --json " + estimate_ + compared_ + odometry).output);
  EXPECT_EQ(json.at("odometry"), folder_ / "odometry.tum");
  EXPECT_EQ(json.at("estimates").at(0).at("unusable").at("no_odometry_nearby"), 1);
  EXPECT_EQ(json.at("estimates").at(0).at("extrapolated"), 1);  // the estimate ends at 2 s
  EXPECT_NEAR(json.at("estimates").at(0).at("translation_m").at("max"), 0.0, 1e-9);
}

TEST_F(EvaluateRelations, FailedWorkExitsWithOneAndOneLine) {
  replace_file(folder_ / "bad.relations", "0 1 nan 0 0 0 0 0\n");
  replace_file(folder_ / "empty.relations", "# none\n");
  replace_file(folder_ / "late.relations", "100 101 0 0 0 0 0 0\n");
  for (const std::string name :
       {"bad.relations", "empty.relations", "late.relations", "none.relations"}) {
    const Outcome outcome =
        run_evaluate("relations " + estimate_ + " --relations " + (folder_ / name));
    EXPECT_EQ(outcome.exit_code, name == "none.relations" ? 2 : 1) << name;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, name)) << outcome.output;
  }
}

TEST_F(EvaluateRelations, PrintsTheKnownErrorOfIntelsOdometry) {
  const std::string odometry = real_data("intel.odom.tum");
  MATCHBOX_SKIP_WITHOUT(odometry);
  const Outcome outcome = run_evaluate("relations " + odometry + " --odometry " + odometry +
                                       " --relations " + real_data("intel.relations"));
  EXPECT_TRUE(contains(outcome.output, " 2907        77             0  7.1979 ± 13.9082"))
      << outcome.output;
}

}  // namespace
}  // namespace matchbox_slam
