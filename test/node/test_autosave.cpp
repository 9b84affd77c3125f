#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

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

TEST(Autosave, RemembersWhyItFailedUntilItIsSaved) {
  std::atomic<bool> is_full{true};
  std::atomic<int> tries{0};
  Autosave autosave(0.02, [&] {
    ++tries;
    if (is_full) {
      throw std::runtime_error("the disk is full");
    }
  });
  const auto wait_for = [&](const std::string& failure) {
    for (int i = 0; i < 200 && autosave.failure() != failure; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(autosave.failure(), failure) << tries;
  };
  EXPECT_EQ(autosave.failure(), "");
  wait_for("the disk is full");
  is_full = false;
  wait_for("");
}

}  // namespace
}  // namespace matchbox_slam
