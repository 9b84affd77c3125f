#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>
#include <vector>

#include "matchbox_slam/common/lender.hpp"

namespace matchbox_slam {
namespace {

std::atomic<int> made{0};

struct Counted {
  Counted() { ++made; }
  int uses = 0;
};

TEST(Lender, LendsAgainWhatIsGivenBack) {
  made = 0;
  Lender<Counted> lender;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(lender.lend()->uses++, i);
  }
  EXPECT_EQ(made, 1);
}

TEST(Lender, LendsEachToOneAtATime) {
  made = 0;
  Lender<Counted> lender;
  for (int round = 0; round < 2; ++round) {
    std::vector<Lender<Counted>::Loan> loans;
    std::set<Counted*> lent;
    for (int i = 0; i < 3; ++i) {
      loans.push_back(lender.lend());
      lent.insert(&*loans.back());
    }
    EXPECT_EQ(lent.size(), 3U);
  }
  EXPECT_EQ(made, 3);
}

TEST(Lender, LendsToManyThreads) {
  constexpr int kThreads = 4;
  constexpr int kRounds = 1000;
  made = 0;
  std::atomic<int> uses{0};
  {
    Lender<Counted> lender;
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < kRounds; ++k) {
          const Lender<Counted>::Loan loan = lender.lend();
          ++loan->uses;  // nobody else has it
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    std::vector<Lender<Counted>::Loan> all;
    for (int i = 0; i < made; ++i) {
      all.push_back(lender.lend());
      uses += all.back()->uses;
    }
  }
  EXPECT_LE(made, kThreads);
  EXPECT_EQ(uses, kThreads * kRounds);
}

}  // namespace
}  // namespace matchbox_slam
