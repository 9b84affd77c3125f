// Of tools/evaluation_plot.hpp: `evaluate --plot` as a user runs it.

#include <gtest/gtest.h>

#include <string>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/evaluate_program.hpp"

namespace matchbox_slam {
namespace {

class EvaluationPlot : public ::testing::Test {
 protected:
  EvaluationPlot() {
    replace_file(truth_, "0 0 0 0 0 0 0 1\n0.5 1 0 0 0 0 0 1\n1 2 0.5 0 0 0 0 1\n");
    replace_file(estimate_, "0 0 1 0 0 0 0 1\n0.5 1 1.1 0 0 0 0 1\n1 2 1 0 0 0 0 1\n");
    replace_file(relations_, "0 1 2 0 0 0 0 0\n0 0.5 1 0 0 0 0 0.1\n");
  }

  TemporaryFolder folder_;
  std::string truth_ = folder_ / "truth.tum";
  std::string estimate_ = folder_ / "_an $estimate$.tum";  // names that matplotlib reads otherwise
  std::string relations_ = folder_ / "a.relations";
  std::string picture_ = folder_ / "error.png";
  std::string of_truth_ = " '" + estimate_ + "' " + truth_ + " --truth " + truth_ + " --plot ";
};

TEST_F(EvaluationPlot, EveryMetricDrawsAPngFile) {
  if (!has_matplotlib()) {
    GTEST_SKIP() << "SKIPPED: /usr/bin/python3 has no matplotlib; install python3-matplotlib";
  }
  const std::string of_relations =
      " '" + estimate_ + "' " + truth_ + " --relations " + relations_ + " --plot ";
  std::string last;
  for (const std::string& arguments :
       {"ate" + of_truth_, "rpe" + of_truth_, "relations" + of_relations}) {
    const Outcome outcome = run_evaluate(arguments + picture_);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "estimate")) << outcome.output;
    const std::string bytes = read_file(picture_);
    EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
    EXPECT_GT(bytes.size(), 10000U);
    EXPECT_NE(bytes, last) << "the picture is not replaced";
    last = bytes;
  }
  EXPECT_EQ(folder_.file_count(), 4U);
}

TEST_F(EvaluationPlot, AnUnwritableFileShowsBeforeTheWork) {
  // The estimate that is missing would be the first to fail.
  const Outcome outcome = run_evaluate("ate " + (folder_ / "none.tum") + " --truth " + truth_ +
                                       " --plot " + (folder_ / "none/error.png"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "cannot write '" + (folder_ / "none/error.png") + "'"))
      << outcome.output;
}

TEST_F(EvaluationPlot, OnlyPngIsDrawn) {
  const Outcome outcome = run_evaluate("rpe" + of_truth_ + (folder_ / "error.pdf"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
}

TEST_F(EvaluationPlot, TheScriptAloneSaysWhatItWantsInOneLine) {
  if (!has_matplotlib()) {
    GTEST_SKIP() << "SKIPPED: /usr/bin/python3 has no matplotlib; install python3-matplotlib";
  }
  const std::string script =
      std::string("\"$(dirname ") + MATCHBOX_EVALUATE + ")/plot_evaluation\"";
  const auto run_script = [&](const std::string& arguments) {
    return run_command("/bin/sh", "-c '" + script + " " + arguments + "'");
  };
  const std::string figure = folder_ / "figure.json";
  for (const std::string text :
       {"", "nonsense", "[]", "{}", R"({"metric": "none"})", R"({"metric": "ate"})", "\xff"}) {
    replace_file(figure, text);
    const Outcome outcome = run_script("<" + figure);
    EXPECT_EQ(outcome.exit_code, 2) << text;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
    EXPECT_EQ(outcome.output.compare(0, 17, "plot_evaluation: "), 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "evaluate --plot")) << outcome.output;
  }
  const Outcome wrong = run_script("--hlep </dev/null");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_EQ(line_count(wrong.output), 1U) << wrong.output;
  EXPECT_TRUE(contains(wrong.output, "--hlep")) << wrong.output;
  const Outcome help = run_script("--help </dev/null");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_TRUE(contains(help.output, "draws what `evaluate` measured")) << help.output;
}

TEST_F(EvaluationPlot, MissingMatplotlibIsOneLineThatSaysSo) {
  replace_file(folder_ / "matplotlib.py", "raise ImportError('No module named matplotlib')\n");
  const Outcome outcome =
      run_command("/usr/bin/env", "PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=" + folder_.path() + " '" +
                                      MATCHBOX_EVALUATE + "' ate" + of_truth_ + picture_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "install python3-matplotlib")) << outcome.output;
  EXPECT_THROW((void)read_file(picture_), FileError);
}

}  // namespace
}  // namespace matchbox_slam
