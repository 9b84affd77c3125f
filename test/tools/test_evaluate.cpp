// Of tools/evaluate_ate.hpp: `evaluate ate` as a user runs it.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/evaluate_program.hpp"

namespace matchbox_slam {
namespace {

class Evaluate : public ::testing::Test {
 protected:
  Evaluate() {
    replace_file(truth_, "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
    // One metre to the left of the truth, all the way.
    replace_file(estimate_,
                 "0 0 1 0 0 0 0 1\n0.5 0.5 1 0 0 0 0 1\n1 1 1 0 0 0 0 1\n2 2 1 0 0 0 0 1\n"
                 "9 0 0 0 0 0 0 1\n");
  }

  TemporaryFolder folder_;
  std::string truth_ = folder_ / "truth.tum";
  std::string estimate_ = folder_ / "estimate.tum";
  std::string ate_ = "ate " + estimate_ + " --max-gap 1 --truth " + truth_;
};

TEST_F(Evaluate, PrintsATableThatStatesTheAlignment) {
  const Outcome aligned = run_evaluate(ate_);
  EXPECT_EQ(aligned.exit_code, 0) << aligned.output;
  EXPECT_TRUE(contains(aligned.output, "Alignment: SE(2)")) << aligned.output;
  EXPECT_TRUE(contains(aligned.output, " 4         1  0.0000  0.0000")) << aligned.output;
  const Outcome raw = run_evaluate(ate_ + " --align none");
  EXPECT_TRUE(contains(raw.output, "Alignment: none")) << raw.output;
  EXPECT_TRUE(contains(raw.output, " 4         1  1.0000  1.0000")) << raw.output;
}

TEST_F(Evaluate, PutsSeveralEstimatesBelowEachOther) {
  const Outcome outcome = run_evaluate("ate " + estimate_ + " " + truth_ +
                                       " --align none --max-gap 1 --truth " + truth_);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.output, "1.0000")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "0.0000")) << outcome.output;
  EXPECT_EQ(line_count(outcome.output), 7U) << outcome.output;
}

TEST_F(Evaluate, PrintsJson) {
  const Outcome outcome = run_evaluate(ate_ + " --json");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.output.front(), '{');
  EXPECT_TRUE(contains(outcome.output, "\"alignment\": \"se2\"")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "\"without_truth\": 1")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "\"y_m\": -1.0")) << outcome.output;
}

TEST_F(Evaluate, NamesThatAreNotUtf8AreReplacedInJson) {
  const std::string latin1 = folder_ / "caf\xE9.tum";
  replace_file(latin1, read_file(truth_));
  for (const std::string command : {"ate", "rpe"}) {
    const Outcome outcome =
        run_evaluate(command + " " + latin1 + " --max-gap 1 --json --truth " + truth_);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "/caf\xEF\xBF\xBD.tum")) << outcome.output;
  }
}

/// A drive of a minute that winds, by a clock that is so much ahead [s].
std::string winding_drive(double ahead, int first = 0, int last = 240) {
  std::vector<StampedPose2> poses;
  Pose2 pose;
  for (int i = 0; i <= last; ++i) {
    if (i >= first) {
      poses.push_back({100.0 + 0.25 * i + ahead, pose});
    }
    pose = pose * Pose2{0.1, 0.0, 0.1 * std::sin(0.001 * i * i)};
  }
  return to_tum(Trajectory(std::move(poses)));
}

TEST_F(Evaluate, WarnsOfLittleOverlapAndSaysHowTheClocksMayDiffer) {
  const auto warning_of = [&](const std::string& estimate, const std::string& options = "") {
    replace_file(estimate_, estimate);
    replace_file(truth_, winding_drive(0.0));
    std::string both;
    for (const std::string command : {"ate ", "rpe "}) {
      const Outcome outcome =
          run_evaluate(command + estimate_ + " --truth " + truth_ + " " + options);
      EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
      const std::size_t at = outcome.output.find("warning: " + estimate_ + ": ");
      const std::string warning =
          at == std::string::npos ? "" : outcome.output.substr(at + 11 + estimate_.size());
      EXPECT_TRUE(both.empty() || both == warning.substr(0, warning.find('\n'))) << both;
      both = warning.substr(0, warning.find('\n'));
    }
    return both;
  };
  EXPECT_EQ(warning_of(winding_drive(12.0)), "") << "80 % of it";
  EXPECT_EQ(warning_of(winding_drive(20.0)),
            "only 161 of 241 poses have truth; the clocks seem to differ: the two fit best with "
            "--time-offset 20.00");
  EXPECT_EQ(warning_of(winding_drive(20.0), "--time-offset -7"),
            "only 133 of 241 poses have truth; the clocks seem to differ: the two fit best with "
            "--time-offset 20.00");
  EXPECT_EQ(warning_of(winding_drive(20.0), "--find-offset"), "");
  EXPECT_EQ(warning_of(winding_drive(0.0, 0, 320)),
            "only 241 of 321 poses have truth; the clocks seem to agree");
  EXPECT_EQ(warning_of("100 0 0 0 0 0 0 1\n110 0 0 0 0 0 0 1\n200 0 0 0 0 0 0 1\n"),
            "only 2 of 3 poses have truth; whether the clocks differ cannot be told");
}

TEST_F(Evaluate, HelpSucceeds) {
  EXPECT_EQ(run_evaluate("--help").exit_code, 0);
  for (const std::string command : {"ate", "rpe", "relations"}) {
    EXPECT_EQ(run_evaluate(command + " --help").exit_code, 0) << command;
  }
}

TEST_F(Evaluate, WrongUsageExitsWithTwoAndOneLine) {
  for (const std::string& arguments :
       {std::string(), std::string("ate"), "ate " + estimate_, ate_ + " --align fine",
        ate_ + " --unknown", "ate " + estimate_ + " --max-gap -3 --truth " + truth_,
        std::string("rpe"), "rpe " + estimate_, "relations " + estimate_,
        ate_ + " " + (folder_ / "none.tum"), "rpe " + estimate_ + " --truth none.tum",
        "ate " + estimate_ + " --truth " + folder_.path()}) {
    const Outcome outcome = run_evaluate(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
    EXPECT_EQ(outcome.output.compare(0, 10, "evaluate: "), 0) << outcome.output;
  }
}

TEST_F(Evaluate, FailedWorkExitsWithOneAndOneLine) {
  replace_file(folder_ / "late.tum", "1000 0 0 0 0 0 0 1\n");
  replace_file(folder_ / "bad.tum", "1000 0 0 0 nan 0 0 1\n");
  replace_file(folder_ / "empty.tum", "");
  for (const std::string command : {"ate ", "rpe "}) {
    for (const std::string name : {"late.tum", "bad.tum", "empty.tum"}) {
      const Outcome outcome = run_evaluate(command + (folder_ / name) + " --truth " + truth_);
      EXPECT_EQ(outcome.exit_code, 1) << name;
      EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
      EXPECT_TRUE(contains(outcome.output, name)) << outcome.output;
    }
  }
}

TEST_F(Evaluate, OutputThatCannotBeWrittenExitsWithOneAndOneLine) {
  for (const std::string& arguments : {ate_, ate_ + " --json", std::string("--help")}) {
    const std::string program = MATCHBOX_EVALUATE;
    const Outcome outcome =
        run_command("/bin/sh", "-c '" + program + " " + arguments + " 2>&1 >/dev/full'");
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "standard output")) << outcome.output;
  }
}

}  // namespace
}  // namespace matchbox_slam
