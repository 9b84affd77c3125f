#pragma once

namespace matchbox_slam {

/// What this process has used so far.
struct ResourceUsage {
  double wall_seconds = 0.0;  ///< since some fixed moment
  double cpu_seconds = 0.0;   ///< of all threads, user and system
  double peak_memory = 0.0;   ///< [MB] resident
};

[[nodiscard]] ResourceUsage resource_usage();

}  // namespace matchbox_slam
