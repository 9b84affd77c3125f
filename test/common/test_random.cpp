#include <gtest/gtest.h>

#include <array>
#include <set>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// The first numbers of xoshiro256** after its state is filled with mix_seed(seed, 0...3), computed
/// independently with integers of unlimited size.
TEST(Random, YieldsTheSameNumbersEverywhere) {
  Random random(1);
  const std::array<std::uint64_t, 4> expected = {0xB3F2AF6D0FC710C5ULL, 0x853B559647364CEAULL,
                                                 0x92F89756082A4514ULL, 0x642E1C7BC266A3A7ULL};
  for (const std::uint64_t number : expected) {
    EXPECT_EQ(random.next(), number);
  }
}

TEST(Random, DependsOnTheSeed) {
  Random a(1);
  Random b(1);
  Random c(2);
  const std::uint64_t first = a.next();
  EXPECT_EQ(first, b.next());
  EXPECT_NE(first, c.next());
}

TEST(Random, UniformFillsItsIntervalEvenly) {
  Random random(3);
  std::array<int, 10> counts{};
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double number = random.uniform(-2.0, 3.0);
    ASSERT_GE(number, -2.0);
    ASSERT_LT(number, 3.0);
    ++counts[static_cast<std::size_t>((number + 2.0) * 2.0)];
  }
  for (const int count : counts) {
    EXPECT_NEAR(count, kDraws / 10.0, 500);  // five standard deviations
  }
}

TEST(Random, GaussianHasTheMomentsOfTheStandardNormal) {
  Random random(4);
  constexpr int kDraws = 200000;
  std::array<double, 5> moments{};
  for (int i = 0; i < kDraws; ++i) {
    const double number = random.gaussian();
    double power = 1.0;
    for (double& moment : moments) {
      moment += power / kDraws;
      power *= number;
    }
  }
  EXPECT_NEAR(moments[1], 0.0, 0.012);
  EXPECT_NEAR(moments[2], 1.0, 0.016);
  EXPECT_NEAR(moments[3], 0.0, 0.045);
  EXPECT_NEAR(moments[4], 3.0, 0.12);
}

TEST(MixSeed, GivesNeighboursDifferentSeeds) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t a = 0; a < 32; ++a) {
    for (std::uint64_t b = 0; b < 32; ++b) {
      seeds.insert(mix_seed(a, b));
    }
  }
  EXPECT_EQ(seeds.size(), 32U * 32U);
}

}  // namespace
}  // namespace matchbox_slam
