#include "matching/hough/lane_dot.hpp"

#include <algorithm>
#include <array>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

// Sums are kept in this many interleaved parts, which every instruction set adds in the same order.
constexpr std::size_t kDotLanes = 16;

MATCHBOX_SIMD_CLONES void add_products(const float* __restrict__ a, const float* __restrict__ b,
                                       std::size_t count, float* __restrict__ lanes) {
  float sums[kDotLanes] = {};  // NOLINT(modernize-avoid-c-arrays): kept in registers
  for (std::size_t i = 0; i < count; i += kDotLanes) {
    for (std::size_t k = 0; k < kDotLanes; ++k) {
      sums[k] += a[i + k] * b[i + k];
    }
  }
  for (std::size_t k = 0; k < kDotLanes; ++k) {
    lanes[k] = sums[k];
  }
}

}  // namespace

float lane_dot(const float* a, const float* b, std::size_t count) {
  const std::size_t whole = count / kDotLanes * kDotLanes;
  std::array<float, kDotLanes> lanes{};
  add_products(a, b, whole, lanes.data());
  float sum = 0.0F;
  for (const float lane : lanes) {
    sum += lane;
  }
  for (std::size_t i = whole; i < count; ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

float lane_dot_between(const float* a, const float* b, std::size_t count, std::size_t begin,
                       std::size_t end) {
  // So that each product stays in its lane.
  const std::size_t first = begin / kDotLanes * kDotLanes;
  const std::size_t last = std::min(count, (end + kDotLanes - 1) / kDotLanes * kDotLanes);
  return lane_dot(a + first, b + first, last - first);
}

}  // namespace matchbox_slam
