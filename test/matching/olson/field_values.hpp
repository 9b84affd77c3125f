#pragma once

#include <cstdint>
#include <numeric>

#include "matching/olson/field_window.hpp"

namespace matchbox_slam {

/// What a window makes of the values of a field: nothing else.
[[nodiscard]] inline FieldWindow::Values unchanged_values() {
  FieldWindow::Values values;
  std::iota(values.begin(), values.end(), std::uint8_t{0});
  return values;
}

}  // namespace matchbox_slam
