#pragma once

#include <sstream>
#include <string>

#include "geometry/trajectory.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// One row a scan, as text with commas: what became of it at the time it was matched.
class ScanTable {
 public:
  ScanTable();

  void add(const ScanOutcome& outcome);
  void clear() { rows_.str({}); }
  [[nodiscard]] std::string text() const;

 private:
  std::ostringstream rows_;
};

/// Where the key scans of a map are now, by their stamps; of two at one stamp the first.
[[nodiscard]] Trajectory key_scan_trajectory(const KeyScans& key_scans);

}  // namespace matchbox_slam
