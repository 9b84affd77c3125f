#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "sensor/packed_ranges.hpp"

namespace matchbox_slam {
namespace {

bool come_back(const std::vector<float>& ranges) {
  const std::vector<float> back = unpack_ranges(pack_ranges(ranges), ranges.size());
  return back.size() == ranges.size() &&
         (ranges.empty() ||
          std::memcmp(back.data(), ranges.data(), ranges.size() * sizeof(float)) == 0);
}

TEST(PackedRanges, OfAnyBitsComeBack) {
  std::mt19937_64 random(1);
  for (std::size_t count = 0; count < 100; ++count) {
    std::vector<float> ranges(count);
    for (float& range : ranges) {
      const auto bits = static_cast<std::uint32_t>(random());
      std::memcpy(&range, &bits, sizeof range);
    }
    EXPECT_TRUE(come_back(ranges)) << count;
  }
}

TEST(PackedRanges, ThatAreNoneComeBack) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(come_back({kInfinity, 1.0F, kNan, -kNan, -kInfinity, 0.0F, -0.0F, 1e-45F, 3e38F}));
  EXPECT_EQ(pack_ranges(std::vector<float>(1040, kInfinity)).size(), 130U + 32U);
}

/// A wall 5 m ahead over a right angle, with the noise of a laser.
TEST(PackedRanges, OfAWallTakeTwoThirdsOfTheirMemory) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::vector<float> ranges(1040);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double angle = 1.5 * (static_cast<double>(i) / 1040.0 - 0.5);
    ranges[i] = static_cast<float>(5.0 / std::cos(angle) + noise(random));
  }
  EXPECT_TRUE(come_back(ranges));
  EXPECT_LT(pack_ranges(ranges).size(), 1040U * 27U / 10U);  // 2.4 bytes a range, of 4
}

}  // namespace
}  // namespace matchbox_slam
