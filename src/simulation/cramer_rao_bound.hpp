#pragma once

#include <Eigen/Core>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "simulation/laser.hpp"

namespace matchbox_slam {

/// Fisher information that a scan holds about the pose of the base in a world that is known
/// exactly. Its inverse bounds the covariance of every unbiased matcher from below; a matcher that
/// knows the world by another noisy scan only cannot reach it. (Censi, "On achievable accuracy for
/// range-finder localization", ICRA 2007.) Where beams graze a wall they count most: the range
/// changes by 1 / cos(incidence) for each metre towards it.
/// @param beams             what the beams met; those that met nothing say nothing.
/// @param scan              what was measured of it: lost readings, and those out of the laser's
///                          limits, say nothing either.
/// @param world_from_base   pose of the base at the scan.
/// @param range_noise       standard deviation of a range [m], > 0.
/// @return over (x, y, theta), x and y along the axes of the base.
[[nodiscard]] Eigen::Matrix3d fisher_information(const std::vector<BeamTruth>& beams,
                                                 const LaserScan& scan,
                                                 const Pose2& world_from_base, double range_noise);

/// Fisher information that two scans hold about the motion between them in a world of straight
/// walls that nobody knows: what a wall tells is by how much the line that the one scan makes of it
/// differs from the other's, and both lines have the noise of their beams. No matcher that
/// takes each wall by itself can use more, even one that knows which beams met the same wall. At
/// most `fisher_information`, and half of it for scans from one place.
/// @param reference_beams, reference_scan  of the first scan.
/// @param beams, scan, world_from_base, range_noise  of the second, as above.
/// @return over (x, y, theta), x and y along the axes of the base at the second scan.
[[nodiscard]] Eigen::Matrix3d fisher_information_of_pair(
    const std::vector<BeamTruth>& reference_beams, const LaserScan& reference_scan,
    const std::vector<BeamTruth>& beams, const LaserScan& scan, const Pose2& world_from_base,
    double range_noise);

}  // namespace matchbox_slam
