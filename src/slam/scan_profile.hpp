#pragma once

#include <cstddef>
#include <tuple>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/hypotheses.hpp"

namespace matchbox_slam {

constexpr std::size_t kSectors = std::tuple_size_v<ScanProfile>;
constexpr double kSectorWidth = 2.0 * kPi / static_cast<double>(kSectors);  // [rad]

/// [rad] in the middle of a sector.
[[nodiscard]] constexpr double angle_of(std::size_t sector) {
  return (static_cast<double>(sector) + 0.5) * kSectorWidth - kPi;
}

[[nodiscard]] ScanProfile profile_of(const PointScan& scan);

/// What a scan shows beside one before it; shares of directions, 0 where there are none.
struct ScanChange {
  double changed = 0.0;    ///< of those in which both saw something: in which it was something else
  double explained = 0.0;  ///< of those in which it saw something: in which the other saw the same
};

[[nodiscard]] ScanChange change_since(const ScanProfile& before, const ScanProfile& profile,
                                      const Pose2& before_from_profile);

}  // namespace matchbox_slam
