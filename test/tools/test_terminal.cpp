#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tools/terminal.hpp"

namespace matchbox_slam {
namespace {

/// What a program with so much time between two lines writes to a file.
std::string written_of(bool quiet, std::chrono::milliseconds between) {
  testing::internal::CaptureStderr();
  Terminal terminal(quiet, between);
  terminal.show_progress(0.129, "3 maps searched in each other");
  terminal.show_progress(0.129, "3 maps searched in each other");
  return testing::internal::GetCapturedStderr();
}

TEST(Terminal, WhereItIsNoneLinesTellOfTheProgressNowAndThen) {
  using std::chrono::hours;
  using std::chrono::milliseconds;
  const std::string line = "12 %: 3 maps searched in each other\n";
  EXPECT_EQ(written_of(false, milliseconds(0)), line + line);
  EXPECT_EQ(written_of(false, hours(1)), "");
  EXPECT_EQ(written_of(true, milliseconds(0)), "");
}

}  // namespace
}  // namespace matchbox_slam
