#pragma once

#include <cstddef>

namespace matchbox_slam {

/// The sum of a[i] b[i], to the same bits on every instruction set.
[[nodiscard]] float lane_dot(const float* a, const float* b, std::size_t count);

/// The same bits in less time, where a[i] b[i] is 0 before `begin` and from `end` on.
[[nodiscard]] float lane_dot_between(const float* a, const float* b, std::size_t count,
                                     std::size_t begin, std::size_t end);

}  // namespace matchbox_slam
