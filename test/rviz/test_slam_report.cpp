#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include "common/error_text.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "rviz/slam_report.hpp"

namespace matchbox_slam {
namespace {

/// Of a node that maps.
SlamReport report_of(const std::string& state) {
  SlamReport report;
  report.match_age = 0.1;
  report.diagnostics_age = 0.5;
  report.state = state;
  report.score = 0.876;
  report.evidence = 2.871;
  report.message = "mapping";
  report.values = {{"State", state}, {"Paused", "no"}, {"Key scans", "120"}, {"Loops closed", "3"}};
  return report;
}

TEST(SlamReport, EveryStateHasItsWordsAndColor) {
  std::set<std::string> headlines;
  std::set<std::string> colors;
  for (const char* state : {"tracking", "doubt", "lost", "recovered"}) {
    const Assessment assessment = assess(report_of(state), "/slam");
    headlines.insert(assessment.headline);
    colors.insert(assessment.color);
    EXPECT_NE(assessment.advice, "") << state;
  }
  EXPECT_EQ(headlines, (std::set<std::string>{"In doubt", "Lost", "Recovered", "Tracking"}));
  EXPECT_EQ(colors.size(), 4U);
  EXPECT_TRUE(contains(assess(report_of("lost"), "/slam").advice, "2D Pose Estimate"));
}

TEST(SlamReport, SilenceMeansThatThereIsNoNode) {
  const Assessment never = assess({}, "/robot/slam");
  EXPECT_EQ(never.headline, "No node");
  EXPECT_TRUE(contains(never.advice, "/robot/slam")) << never.advice;
  SlamReport gone = report_of("tracking");
  gone.match_age = gone.diagnostics_age = 10.0;
  EXPECT_EQ(assess(gone, "/slam").headline, "No node");
}

TEST(SlamReport, WithoutScansTheNodesOwnWordsTellWhy) {
  SlamReport report = report_of("tracking");
  report.match_age = 10.0;
  report.level = 1;
  report.message = "no scans are coming in";
  EXPECT_EQ(assess(report, "/slam").headline, "No scans");
  EXPECT_EQ(assess(report, "/slam").advice, "no scans are coming in");
  const std::string color = assess(report, "/slam").color;
  report.level = 2;
  EXPECT_NE(assess(report, "/slam").color, color) << "stopped, say";
}

TEST(SlamReport, APauseIsNoLackOfScans) {
  SlamReport report = report_of("tracking");
  report.match_age = 10.0;
  report.values["Paused"] = "yes";
  EXPECT_EQ(assess(report, "/slam").headline, "Paused");
}

TEST(SlamReport, AWarningIsToldWhileItTracks) {
  SlamReport report = report_of("tracking");
  report.level = 1;
  report.message = "3 scans skipped; the last: no transform";
  EXPECT_EQ(assess(report, "/slam").headline, "Tracking");
  EXPECT_EQ(assess(report, "/slam").advice, report.message);
  report.level = 2;
  EXPECT_EQ(assess(report, "/slam").headline, "Error");
  report.values["State"] = "lost";  // a moment ago
  EXPECT_EQ(assess(report, "/slam").advice, "The scans match the map.");
}

TEST(SlamReport, ALoopIsToldForSomeSeconds) {
  SlamReport report = report_of("tracking");
  report.loop_age = 2.0;
  EXPECT_TRUE(contains(assess(report, "/slam").advice, "A loop was closed"));
  report.loop_age = 60.0;
  EXPECT_FALSE(contains(assess(report, "/slam").advice, "loop"));
}

TEST(SlamReport, FiguresAreThoseThatAreKnown) {
  EXPECT_EQ(figures_of(report_of("tracking")),
            "Score 0.88, evidence 2.87\n120 key scans, 3 loops closed");
  EXPECT_EQ(figures_of({}), "");
  SlamReport first = report_of("tracking");
  first.values["Key scans"] = first.values["Loops closed"] = "1";
  EXPECT_TRUE(contains(figures_of(first), "\n1 key scan, 1 loop closed")) << figures_of(first);
  SlamReport no_match = report_of("tracking");
  no_match.match_age = std::numeric_limits<double>::infinity();
  EXPECT_EQ(figures_of(no_match), "120 key scans, 3 loops closed");
}

TEST(SlamReport, APlaceIsALine) {
  EXPECT_EQ(text_of({1.234, -5.678, kPi / 2.0, 0.913}, 2),
            "2:  score 0.91,  x 1.23 m,  y -5.68 m,  90\u00b0");
}

TEST(SlamReport, ReadsTheWordsOfAnOption) {
  EXPECT_EQ(words_of("{'enum_description': '', 'enum': [{'name': 'a', 'type': 'str', 'value': "
                     "'a', 'srcline': 0}, {'name': 'b', 'type': 'str', 'value': 'b'}]}"),
            (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(words_of("").empty());
  EXPECT_EQ(words_of("'value': 'cut off"), std::vector<std::string>{"cut off"});
}

TEST(SlamReport, AMapIsNamedByAnyOfItsFiles) {
  EXPECT_EQ(without_map_extension("/maps/office.slam"), "/maps/office");
  EXPECT_EQ(without_map_extension("office.yaml"), "office");
  EXPECT_EQ(without_map_extension("office.2"), "office.2");
  EXPECT_EQ(without_map_extension(".slam"), ".slam");
}

TEST(SlamReport, AMapIsLoadedByAnyOfItsFiles) {
  for (const char* file : {"/maps/office", "/maps/office.slam", "/maps/office.pgm",
                           "/maps/office.png", "/maps/office.occupancy.png"}) {
    EXPECT_EQ(file_to_load(file), "/maps/office.slam");
  }
  EXPECT_EQ(file_to_load("/maps/office.yaml"), "/maps/office.yaml") << "of map_server";
  EXPECT_EQ(file_to_load("2026.11.23"), "2026.11.23.slam");
  EXPECT_EQ(file_to_load("2026.11.23.pgm"), "2026.11.23.slam");
}

TEST(SlamReport, TellsOfMapsApartAndWhereTheRobotMayBe) {
  SlamReport report = report_of("tracking");
  report.values["Maps apart"] = "0";
  report.hypotheses = {{1.0, 2.0, 0.0, 1.0}};
  EXPECT_EQ(figures_of(report), figures_of(report_of("tracking")));
  EXPECT_EQ(hypotheses_of(report), "") << "there is one place";
  report.values["Maps apart"] = "1";
  EXPECT_TRUE(contains(figures_of(report), "3 loops closed, 1 map apart")) << figures_of(report);
  report.values["Maps apart"] = "2";
  EXPECT_TRUE(contains(figures_of(report), "3 loops closed, 2 maps apart")) << figures_of(report);
  report.hypotheses = {{1.0, 2.0, kPi / 2.0, 0.62}, {-3.5, 0.25, 0.0, 0.3}};
  report.elsewhere = 0.08;
  EXPECT_EQ(hypotheses_of(report),
            "62 % at x 1.00 m,  y 2.00 m,  90\u00b0\n30 % at x -3.50 m,  y 0.25 m,  0\u00b0\n"
            "8 % elsewhere");
  report.hypotheses.resize(5);
  EXPECT_TRUE(contains(hypotheses_of(report), "\n8 % elsewhere, 2 more places"));
  report.hypotheses.resize(4);
  EXPECT_TRUE(contains(hypotheses_of(report), "\n8 % elsewhere, 1 more place"));
  EXPECT_FALSE(contains(hypotheses_of(report), "1 more places"));
  SlamReport lost = report_of("lost");
  lost.hypotheses = {{1.0, 2.0, 0.0, 1.0}};
  EXPECT_EQ(hypotheses_of(lost), "100 % at x 1.00 m,  y 2.00 m,  0\u00b0\n0 % elsewhere");
  lost.match_age = 10.0;
  EXPECT_EQ(hypotheses_of(lost), "") << "nothing is heard of it any more";
}

}  // namespace
}  // namespace matchbox_slam
