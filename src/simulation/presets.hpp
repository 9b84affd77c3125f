#pragma once

#include <string>
#include <vector>

#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// Options that go together, under one name.
struct Preset {
  std::string name;
  std::string meaning;  ///< for --help
  Parameters values;    ///< those other than by default
};

/// Lasers, of LaserOptions: what they measure, and what their drivers tell of it.
[[nodiscard]] std::vector<Preset> sensor_presets();

/// Kinds of odometry, of OdometryOptions, from perfect to none.
[[nodiscard]] std::vector<Preset> odometry_presets();

/// The odometry of which nothing is told.
constexpr const char* kNoOdometry = "none";

/// The preset of that name. Throws ConfigurationError naming those that there are.
/// @param flag  for the error text.
[[nodiscard]] Preset preset_named(const std::vector<Preset>& presets, const std::string& flag,
                                  const std::string& name);

/// What may be given, for --help.
[[nodiscard]] std::string preset_help(const std::vector<Preset>& presets);

}  // namespace matchbox_slam
