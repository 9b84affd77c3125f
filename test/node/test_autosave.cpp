#include <gtest/gtest.h>

#include <atomic>

#include "node/autosave.hpp"

namespace matchbox_slam {
namespace {

TEST(Autosave, BeginsItsPeriodAnewWhereSomebodyElseHasSaved) {
  constexpr double kPeriod = 3600.0;
  std::atomic<int> saved{0};
  Autosave autosave(kPeriod, [&] { ++saved; });
  const auto due = autosave.due();
  autosave.postpone();
  EXPECT_GT(autosave.due(), due);
  EXPECT_LE(autosave.due(), std::chrono::steady_clock::now() + std::chrono::hours(1));
  EXPECT_EQ(saved, 0);
}

}  // namespace
}  // namespace matchbox_slam
