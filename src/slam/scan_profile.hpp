#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

constexpr std::size_t kProfileSectors = 72;

/// How far a scan saw in each direction [m]: the nearest hit of each sector around the base, from
/// -pi on; 0 where there is none.
[[nodiscard]] std::vector<float> profile_of(const PointScan& scan);

/// Share of the directions, of those in which both saw something, in which a scan saw something
/// else than one before; 0 where there are none.
[[nodiscard]] double changed_share(const std::vector<float>& profile,
                                   const std::vector<float>& before,
                                   const Pose2& before_from_profile);

}  // namespace matchbox_slam
