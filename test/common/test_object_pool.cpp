#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>
#include <vector>

#include "matchbox_slam/common/object_pool.hpp"

namespace matchbox_slam {
namespace {

std::atomic<int> constructed{0};

struct Counted {
  Counted() { ++constructed; }
  int uses = 0;
};

TEST(ObjectPool, LendsAgainWhatIsGivenBack) {
  constructed = 0;
  ObjectPool<Counted> pool;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(pool.acquire()->uses++, i);
  }
  EXPECT_EQ(constructed, 1);
}

TEST(ObjectPool, LendsEachToOneAtATime) {
  constructed = 0;
  ObjectPool<Counted> pool;
  for (int round = 0; round < 2; ++round) {
    std::vector<ObjectPool<Counted>::Handle> handles;
    std::set<Counted*> lent;
    for (int i = 0; i < 3; ++i) {
      handles.push_back(pool.acquire());
      lent.insert(&*handles.back());
    }
    EXPECT_EQ(lent.size(), 3U);
  }
  EXPECT_EQ(constructed, 3);
}

TEST(ObjectPool, LendsToManyThreads) {
  constexpr int kThreads = 4;
  constexpr int kRounds = 1000;
  constructed = 0;
  std::atomic<int> uses{0};
  {
    ObjectPool<Counted> pool;
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < kRounds; ++k) {
          const ObjectPool<Counted>::Handle handle = pool.acquire();
          ++handle->uses;  // nobody else has it
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    std::vector<ObjectPool<Counted>::Handle> all;
    for (int i = 0; i < constructed; ++i) {
      all.push_back(pool.acquire());
      uses += all.back()->uses;
    }
  }
  EXPECT_LE(constructed, kThreads);
  EXPECT_EQ(uses, kThreads * kRounds);
}

}  // namespace
}  // namespace matchbox_slam
