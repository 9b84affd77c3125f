#include <gtest/gtest.h>

#include "common/scratch_buffer.hpp"

namespace matchbox_slam {
namespace {

using Array = ScratchBuffer<int>;

TEST(ScratchBuffer, KeepsItsMemoryForFewer) {
  Array array;
  const int* const large = array.make(1000);
  EXPECT_EQ(array.make(10), large);
  EXPECT_EQ(array.make(1000), large);
  EXPECT_EQ(array.make(1001), large) << "a bit more is there";
  EXPECT_EQ(array.data(), large);
}

TEST(ScratchBuffer, LetsGoOfWhatALargeUseNeeded) {
  constexpr std::size_t kLarge = 2 * Array::kKeptBytes / sizeof(int);
  Array array;
  EXPECT_EQ(array.capacity(), 0U);
  static_cast<void>(array.make(kLarge));
  EXPECT_EQ(array.capacity(), kLarge);
  static_cast<void>(array.make(kLarge / 2 + 1));
  EXPECT_EQ(array.capacity(), kLarge) << "still a large use";
  static_cast<void>(array.make(100));
  EXPECT_LE(sizeof(int) * array.capacity(), Array::kKeptBytes);
}

}  // namespace
}  // namespace matchbox_slam
