#pragma once

#include <string>
#include <vector>

#include "geometry/trajectory.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// One row a scan, as text with commas: what became of it at the time it was matched.
class ScanTable {
 public:
  void add(const ScanOutcome& outcome);
  void clear() { pages_.clear(); }
  void write(const ByteSink& sink) const;

 private:
  std::vector<std::string> pages_;  ///< of rows: one text would be twice as large while it grows
};

/// Where the key scans of a map are now, by their stamps; of two at one stamp the first.
[[nodiscard]] Trajectory key_scan_trajectory(const KeyScans& key_scans);

}  // namespace matchbox_slam
