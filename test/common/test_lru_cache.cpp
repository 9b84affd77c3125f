#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "common/lru_cache.hpp"

namespace matchbox_slam {
namespace {

using Cache = LruCache<std::string>;

std::size_t size_of(const std::string& text) { return text.size(); }

TEST(LruCache, KeepsWhatWasUsedLastUpToItsBound) {
  Cache cache(25, size_of);
  int made = 0;
  const auto get = [&](std::uint64_t key) {
    return cache.get(key, [&] {
      ++made;
      return std::string(10, static_cast<char>('a' + key));
    });
  };
  const std::shared_ptr<const std::string> a = get(0);
  (void)get(1);
  EXPECT_EQ(get(0), a);
  EXPECT_EQ(made, 2);
  (void)get(2);  // drops 1, which was used longest ago
  EXPECT_EQ(cache.bytes(), 20U);
  EXPECT_EQ(get(0), a);
  EXPECT_EQ(made, 3);
  EXPECT_EQ(*get(1), "bbbbbbbbbb");
  EXPECT_EQ(made, 4);
  (void)get(3);  // drops 0, which lives on in the hands of who has it
  EXPECT_EQ(*a, "aaaaaaaaaa");
  EXPECT_NE(get(0), a);
}

TEST(LruCache, KeepsASingleValueOfAnySize) {
  Cache cache(5, size_of);
  const auto make = [] { return std::string(10, 'x'); };
  const std::shared_ptr<const std::string> large = cache.get(0, make);
  EXPECT_EQ(cache.get(0, make), large);
  EXPECT_EQ(cache.bytes(), 10U);
}

TEST(LruCache, GivesAllThreadsTheirValues) {
  Cache cache(30, size_of);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (std::uint64_t i = 0; i < 2000; ++i) {
        const std::string expected(1 + i % 7, 'x');
        wrong += *cache.get(i % 7, [&] { return std::string(expected); }) == expected ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(cache.bytes(), 30U);
}

}  // namespace
}  // namespace matchbox_slam
