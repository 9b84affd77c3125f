#pragma once

#include <cstdint>
#include <vector>

#include "matchbox_slam/sensor/laser_scan.hpp"
#include "simulation/fault.hpp"

namespace matchbox_slam {

/// Draws covers and people (kCovered, kPeople) into a scan. Each person hides about a twentieth of
/// the beams, at a share of its own of the distance to the wall, and wanders about the laser.
/// @param since_start  of its stamp [s].
/// @param seed         of the run: where people are has to go on from scan to scan.
void add_scan_faults(double since_start, const std::vector<Fault>& faults, std::uint64_t seed,
                     LaserScan& scan);

}  // namespace matchbox_slam
