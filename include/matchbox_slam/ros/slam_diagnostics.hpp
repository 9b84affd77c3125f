#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <string>
#include <vector>

#include "matchbox_slam/ros/scan_queue.hpp"

namespace matchbox_slam {

/// What /diagnostics tells about the mapping.
struct SlamHealth {
  ScanAccount account;
  std::size_t waiting = 0;  ///< scans
  bool stopped = false;     ///< at a jump of time
  std::vector<float> recent_match_seconds;
  std::string matcher;
  std::size_t map_bytes = 0;
  std::string last_skip;  ///< why a scan was skipped last, for people
};

/// Judges the mapping by what has happened since it was asked last: an error when it has stopped, a
/// warning when scans were skipped or none came, otherwise fine.
class SlamDiagnostics {
 public:
  void fill(const SlamHealth& health, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  ScanAccount before_;
};

}  // namespace matchbox_slam
