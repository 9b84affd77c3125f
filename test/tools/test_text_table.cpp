#include <gtest/gtest.h>

#include "tools/text_table.hpp"

namespace matchbox_slam {
namespace {

TEST(FormatTable, FirstColumnIsFlushLeftTheOthersFlushRight) {
  EXPECT_EQ(format_table({{"name", "m"}, {"a", "1.25"}}), "name     m\na     1.25\n");
}

TEST(FormatTable, CountsCharactersAndNotBytes) {
  EXPECT_EQ(format_table({{"e", "1 ± 2"}, {"ü", "–"}}), "e  1 ± 2\nü      –\n");
}

}  // namespace
}  // namespace matchbox_slam
