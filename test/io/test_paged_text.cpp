#include <gtest/gtest.h>

#include <iomanip>
#include <string>
#include <vector>

#include "io/paged_text.hpp"

namespace matchbox_slam {
namespace {

TEST(PagedText, GivesWholeLinesAPageAtATime) {
  std::vector<std::string> pages;
  std::string expected;
  PagedText text([&pages](const std::string& page) { pages.push_back(page); });
  text.line() << std::fixed << std::setprecision(1);
  for (int i = 0; i < 20'000; ++i) {
    text.line() << i << ' ' << 0.5;
    text.end_line();
    expected += std::to_string(i) + " 0.5\n";
  }
  EXPECT_GE(pages.size(), 2U) << "before it is finished";
  text.finish();
  std::string all;
  for (const std::string& page : pages) {
    EXPECT_EQ(page.back(), '\n');
    EXPECT_LT(page.size(), 70'000U);
    all += page;
  }
  EXPECT_EQ(all, expected);
}

TEST(PagedText, OfNothingIsEmpty) {
  EXPECT_EQ(text_of_pages([](const ByteSink& sink) { PagedText(sink).finish(); }), "");
}

}  // namespace
}  // namespace matchbox_slam
