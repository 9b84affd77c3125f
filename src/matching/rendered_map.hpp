#pragma once

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// The map that key scans make, in their order.
[[nodiscard]] SlamMap rendered(const PlacedScans& keys, const MapOptions& map_options,
                               const LikelihoodFieldOptions& field_options, MapUse use);

}  // namespace matchbox_slam
