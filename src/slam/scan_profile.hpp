#pragma once

#include <Eigen/Core>
#include <cmath>
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

/// [sectors] from -pi to a direction.
[[nodiscard]] inline double sectors_to(const Eigen::Vector2d& direction) {
  return (std::atan2(direction.y(), direction.x()) + kPi) / kSectorWidth;
}

[[nodiscard]] ScanProfile profile_of(const PointScan& scan);

/// Share of the directions, of those in which both saw something, in which a scan saw something
/// else than one before; 0 where there are none.
[[nodiscard]] double changed_share(const ScanProfile& profile, const ScanProfile& before,
                                   const Pose2& before_from_profile);

}  // namespace matchbox_slam
