#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/report_page.hpp"

namespace matchbox_slam {
namespace {

using nlohmann::json;

std::vector<PagePoint> sure_points(std::size_t count) {
  std::vector<PagePoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    points[i].time = 0.1 * static_cast<double>(i);
    points[i].stamp = 1000.0 + points[i].time;
    points[i].place = Eigen::Vector2d(static_cast<double>(i), -1.0);
    points[i].sigma = 0.01;
  }
  return points;
}

/// The text between two others that the page has once.
std::string between(const std::string& page, const std::string& before, const std::string& after) {
  const std::size_t begin = page.find(before) + before.size();
  return page.substr(begin, page.find(after, begin) - begin);
}

json data_in(const std::string& page) {
  return json::parse(between(page, R"(<script type="application/json" id="data">)", "</script>"));
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) {
    ++count;
  }
  return count;
}

TEST(ReportPage, HoldsTheReportAsItIs) {
  const json report = {{"bags", {"a.bag"}}, {"cpu_s", 1.234567}, {"damage", nullptr}};
  EXPECT_EQ(data_in(report_page(report.dump(), sure_points(3), {})).at("report"), report);
}

TEST(ReportPage, LetsNoNameEndTheScriptThatItIsIn) {
  const json report = {
      {"bags", {"</script><b>\"'&\\.bag", "<!--<script>", "\xc3\xa4 \xe2\x80\xa8"}}};
  const std::string plain = report_page("{}", sure_points(3), {});
  const std::string page = report_page(report.dump(), sure_points(3), {});
  for (const std::string tag : {"<script", "</script", "<b>", "<!--"}) {
    EXPECT_EQ(count_of(page, tag), count_of(plain, tag)) << tag;
  }
  EXPECT_EQ(data_in(page).at("report"), report);
}

TEST(ReportPage, HoldsThePointsAndTellsOfThoseThatAreNotInTheMap) {
  std::vector<PagePoint> points = sure_points(3);
  points[1].place.reset();
  points[1].state = TrackingState::kLost;
  points[2].certainty = Certainty::kNewGround;
  points[2].sigma = 0.123456;
  const json data = data_in(report_page("{}", points, {}));
  EXPECT_EQ(data.at("points"), json({{"time", {0.0, 0.1, 0.2}},
                                     {"x", {0.0, nullptr, 2.0}},
                                     {"y", {-1.0, nullptr, -1.0}},
                                     {"sigma", {0.01, 0.01, 0.12346}},
                                     {"reason", {"", "lost", "new_ground"}}}));
  EXPECT_EQ(data.at("scans"), 3);
}

TEST(ReportPage, ListsDoubtedStretches) {
  std::vector<PagePoint> points = sure_points(10);
  points[2].state = points[3].state = TrackingState::kDoubt;
  points[3].certainty = points[5].certainty = Certainty::kUnmatched;
  points[4].state = TrackingState::kLost;
  points[9].certainty = Certainty::kOvertaken;
  const json data = data_in(report_page("{}", points, {}));
  const auto row = [](const char* reason, double from, double to, int scans, int unmatched) {
    return json({{"reason", reason},
                 {"from", from},
                 {"to", to},
                 {"stamp", 1000.0 + from},
                 {"scans", scans},
                 {"unmatched", unmatched}});
  };
  EXPECT_EQ(data.at("stretches"),
            json::array({row("doubt", 0.2, 0.3, 2, 1), row("lost", 0.4, 0.4, 1, 0),
                         row("unmatched", 0.5, 0.5, 1, 1), row("overtaken", 0.9, 0.9, 1, 0)}));
  EXPECT_EQ(data.at("stretches_in_all"), 4);
}

TEST(ReportPage, HasAnEntryForEveryReasonOfTheData) {
  const std::string page = report_page("{}", sure_points(1), {});
  const std::string kinds = between(page, "const kinds = {", "};");
  for (const TrackingState state :
       {TrackingState::kDoubt, TrackingState::kLost, TrackingState::kRecovered}) {
    EXPECT_EQ(count_of(kinds, std::string("  ") + to_string(state) + ": {"), 1U);
  }
  for (const Certainty certainty :
       {Certainty::kOvertaken, Certainty::kNewGround, Certainty::kUnmatched}) {
    EXPECT_EQ(count_of(kinds, std::string("  ") + to_string(certainty) + ": {"), 1U);
  }
}

TEST(ReportPage, ThinsButKeepsTheEndsThePeaksAndEveryDoubtedStretch) {
  std::vector<PagePoint> points = sure_points(100001);
  points[777].sigma = 3.0;
  points[50001].state = TrackingState::kDoubt;
  for (std::size_t i = 70003; i < 70013; ++i) {
    points[i].certainty = Certainty::kUnmatched;
  }
  const std::vector<std::size_t> drawn = thinned(points, doubted_stretches(points), 1000);
  EXPECT_LE(drawn.size(), 1000U);
  EXPECT_GE(drawn.size(), 990U);
  EXPECT_TRUE(std::is_sorted(drawn.begin(), drawn.end()));
  for (const std::size_t kept : {0, 777, 50001, 70003, 70012, 100000}) {
    EXPECT_TRUE(std::binary_search(drawn.begin(), drawn.end(), kept)) << kept;
  }
  for (std::size_t i = 1; i < drawn.size(); ++i) {
    EXPECT_LE(drawn[i] - drawn[i - 1], 205U);
  }
}

TEST(ReportPage, KeepsTheGravestOfTooManyStretches) {
  std::vector<PagePoint> points = sure_points(40);
  points[1].certainty = points[2].certainty = points[3].certainty = Certainty::kNewGround;
  points[10].state = TrackingState::kLost;
  points[20].certainty = Certainty::kUnmatched;
  points[30].certainty = points[31].certainty = Certainty::kUnmatched;
  std::vector<std::size_t> begins;
  for (const DoubtedStretch& one : gravest(doubted_stretches(points), 3)) {
    begins.push_back(one.begin);
  }
  EXPECT_EQ(begins, (std::vector<std::size_t>{1, 10, 30}));
}

TEST(ReportPage, StaysSmallOfALongDriveThatIsDoubtedEverywhere) {
  std::vector<PagePoint> points = sure_points(200000);
  for (std::size_t i = 0; i < points.size(); i += 2) {
    points[i].certainty = Certainty::kNewGround;
  }
  const std::string page = report_page("{}", points, {});
  EXPECT_LT(page.size(), 500000U);
  EXPECT_EQ(data_in(page).at("stretches_in_all"), 100000);
}

TEST(ReportPage, HoldsThePictureUnlessItIsLarge) {
  const PagePicture small{"\x89PNG", 4, 3, {20.0, {1.5, 2.5}}};
  const std::string page = report_page("{}", sure_points(1), small);
  EXPECT_EQ(count_of(page, "src=\"data:image/png;base64,iVBORw==\""), 1U);
  EXPECT_EQ(data_in(page).at("picture"), json({{"inside", true},
                                               {"width", 4},
                                               {"height", 3},
                                               {"pixels_per_metre", 20.0},
                                               {"left", 1.5},
                                               {"top", 2.5}}));
  const PagePicture large{std::string(kLargestPagePicture + 1, 'x'), 4, 3, {}};
  const std::string beside = report_page("{}", sure_points(1), large);
  EXPECT_EQ(count_of(beside, "src=\"map.png\""), 1U);
  EXPECT_EQ(data_in(beside).at("picture").at("inside"), false);
}

TEST(ReportPage, AsksNoNetwork) {
  const std::string page = report_page("{}", sure_points(1), {});
  for (const std::string address : {"http:", "https:", "url(", "import(", "fetch("}) {
    EXPECT_EQ(count_of(page, address), 0U) << address;
  }
}

}  // namespace
}  // namespace matchbox_slam
