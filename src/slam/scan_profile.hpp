#pragma once

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/hypotheses.hpp"

namespace matchbox_slam {

[[nodiscard]] ScanProfile profile_of(const PointScan& scan);

/// Share of the directions, of those in which both saw something, in which a scan saw something
/// else than one before; 0 where there are none.
[[nodiscard]] double changed_share(const ScanProfile& profile, const ScanProfile& before,
                                   const Pose2& before_from_profile);

}  // namespace matchbox_slam
