#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/lasers/secondary_lasers.hpp"

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

[[nodiscard]] LaserPlace place_of(const SecondaryLaser& laser);

enum class LaserUse { kUnsure, kUsed, kContradictory };
[[nodiscard]] LaserUse use_of(const SecondaryLaser& laser);

/// What to say of beams that end on the robot, and with which option they are left out.
/// @param sectors  where, of all lasers.
/// @param masked   that are left out already, by the option.
/// @param set      how to set an option, before its name and value.
[[nodiscard]] std::string text_of_robot_beams(const std::vector<double>& sectors,
                                              const std::vector<double>& masked,
                                              const std::string& set);

/// What to say of scans of so few returns that matching them is worth little. Empty: they are not.
/// @param returns  of a scan, the median; none: not known.
[[nodiscard]] std::string text_of_few_returns(std::optional<std::size_t> returns);

/// Whether and why its scans are used, for people.
[[nodiscard]] std::string text_of(const SecondaryLaser& laser, const std::string& topic);

}  // namespace matchbox_slam
