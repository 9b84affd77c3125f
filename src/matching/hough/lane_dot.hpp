#pragma once

#include <cstddef>

namespace matchbox_slam {

/// The sum of a[i] b[i], to the same bits on every instruction set.
[[nodiscard]] float lane_dot(const float* a, const float* b, std::size_t count);

}  // namespace matchbox_slam
