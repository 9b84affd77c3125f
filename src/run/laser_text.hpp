#pragma once

#include <Eigen/Core>
#include <string>

#include "matchbox_slam/slam/further_lasers.hpp"

namespace matchbox_slam {

/// Where a laser is, as estimated from its scans.
struct LaserPlace {
  Pose2 base_from_laser;
  Eigen::Vector3d sigma;     ///< of that: (x [m], y [m], theta [rad])
  double from_tf = 0.0;      ///< [m]
  double turned = 0.0;       ///< [rad], from where tf has it
  double delay = 0.0;        ///< [s] by which its scans are later than their stamps say
  double delay_sigma = 0.0;  ///< [s]
};

[[nodiscard]] LaserPlace place_of(const FurtherLaser& laser);

enum class LaserUse { kUnsure, kUsed, kContradictory };
[[nodiscard]] LaserUse use_of(const FurtherLaser& laser);

/// Whether and why its scans are used, for people.
[[nodiscard]] std::string text_of(const FurtherLaser& laser, const std::string& topic);

}  // namespace matchbox_slam
