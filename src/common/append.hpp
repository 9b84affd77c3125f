#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace matchbox_slam {

/// Appends to what a long drive has a large part of its memory in: where there is no room, the
/// vector grows by an eighth, and not to twice its size as by push_back.
template <typename Value>
void append_sparingly(Value value, std::vector<Value>& values) {
  constexpr std::size_t kMinGrowth = 16;
  if (values.size() == values.capacity()) {
    values.reserve(values.size() + values.size() / 8 + kMinGrowth);
  }
  values.push_back(std::move(value));
}

}  // namespace matchbox_slam
