#pragma once

#include <vector>

namespace matchbox_slam {

/// A planar scan as the laser measured it. Beam k points at `angle_min + k * angle_increment` in
/// the laser's own x-y plane and was measured at `stamp + k * time_increment`.
struct LaserScan {
  double stamp = 0.0;            ///< [s], time of the first beam
  double angle_min = 0.0;        ///< [rad]
  double angle_increment = 0.0;  ///< [rad], negative when the laser sweeps clockwise
  double time_increment = 0.0;   ///< [s] between beams, 0 when all are taken at once
  double range_min = 0.0;        ///< [m]
  double range_max = 0.0;        ///< [m]
  std::vector<float> ranges;     ///< [m], by REP-117; any length

  /// Time from the first beam to the last [s].
  [[nodiscard]] double duration() const {
    return ranges.empty() ? 0.0 : time_increment * static_cast<double>(ranges.size() - 1);
  }
};

}  // namespace matchbox_slam
