#include <gtest/gtest.h>

#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matching/hough/lane_dot.hpp"

namespace matchbox_slam {
namespace {

std::vector<float> random_values(Random& random, std::size_t count, std::size_t begin,
                                 std::size_t end) {
  std::vector<float> values(count, 0.0F);
  for (std::size_t i = begin; i < end; ++i) {
    values[i] = static_cast<float>(random.uniform(-1.0, 1.0));
  }
  return values;
}

TEST(LaneDot, BetweenIsTheWholeToTheLastBit) {
  Random random(3);
  for (std::size_t count = 1; count < 80; ++count) {
    const std::vector<float> a = random_values(random, count, 0, count);
    for (std::size_t begin = 0; begin < count; begin += 3) {
      for (std::size_t end = begin + 1; end <= count; end += 2) {
        const std::vector<float> b = random_values(random, count, begin, end);
        EXPECT_EQ(lane_dot_between(a.data(), b.data(), count, begin, end),
                  lane_dot(a.data(), b.data(), count))
            << count << " cells, " << begin << " to " << end;
      }
    }
  }
}

TEST(LaneDot, SumsProducts) {
  const std::vector<float> a(37, 2.0F);
  const std::vector<float> b(37, 0.5F);
  EXPECT_EQ(lane_dot(a.data(), b.data(), a.size()), 37.0F);
}

}  // namespace
}  // namespace matchbox_slam
