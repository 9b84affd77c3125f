#include <gtest/gtest.h>

#include "common/number_text.hpp"

namespace matchbox_slam {
namespace {

TEST(FixedText, HasSoManyDecimals) {
  EXPECT_EQ(fixed_text(1.0 / 3.0, 3), "0.333");
  EXPECT_EQ(fixed_text(-2.5, 0), "-2");
}

TEST(FiniteNumber, TakesWholeNumbersAndOnesWithAFraction) {
  EXPECT_EQ(finite_number("-3"), -3.0);
  EXPECT_EQ(finite_number("2.5e-1"), 0.25);
}

TEST(FiniteNumber, IsNoneForAnythingElse) {
  for (const char* text :
       {"", "one", "1,5", "2 m", ".nan", ".inf", "nan", "inf", "1e999", "true"}) {
    EXPECT_FALSE(finite_number(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace matchbox_slam
