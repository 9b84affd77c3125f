#pragma once

#include <cmath>

namespace matchbox_slam {

constexpr double kPi = 3.14159265358979323846;

/// The angle in [-pi, pi) that differs from `angle` [rad] by whole turns. The only place that
/// wraps.
[[nodiscard]] inline double wrap_angle(double angle) {
  if (angle >= -kPi && angle < kPi) {
    return angle;
  }
  const double wrapped = angle - 2.0 * kPi * std::floor((angle + kPi) / (2.0 * kPi));
  // Rounding may land exactly on the upper end, which belongs to the next turn.
  return wrapped >= kPi ? -kPi : wrapped;
}

[[nodiscard]] constexpr double degrees_to_radians(double degrees) {
  return degrees * (kPi / 180.0);
}
[[nodiscard]] constexpr double radians_to_degrees(double radians) {
  return radians * (180.0 / kPi);
}

}  // namespace matchbox_slam
