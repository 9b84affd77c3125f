#pragma once

#include <string>

#include "geometry/trajectory.hpp"
#include "io/paged_text.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// One row a scan, as text with commas: what became of it at the time it was matched.
class ScanTable {
 public:
  /// @param sink  gets a page of rows at a time. What it throws passes through.
  explicit ScanTable(ByteSink sink);

  void add(const ScanOutcome& outcome);
  /// Gives the last rows to the sink.
  void finish() { text_.finish(); }

 private:
  PagedText text_;
};

/// Where the key scans of a map are now, by their stamps; of two at one stamp the first.
/// Without what nobody measured, the views of an image.
[[nodiscard]] Trajectory key_scan_trajectory(const KeyScans& key_scans);

}  // namespace matchbox_slam
