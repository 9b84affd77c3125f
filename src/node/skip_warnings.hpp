#pragma once

#include <ros/time.h>

#include <map>
#include <string>

#include "ros/scan_queue.hpp"

namespace matchbox_slam {

/// Tells of skipped scans in the node's log: each reason once in a while, not each scan.
class SkipWarnings {
 public:
  /// Takes what the queue has skipped since the last call.
  void tell(ScanQueue& queue);

  /// About the scan that was skipped last; empty when none was.
  [[nodiscard]] const std::string& latest() const { return latest_; }

 private:
  std::map<SkipReason, ros::WallTime> told_;
  std::string latest_;
};

}  // namespace matchbox_slam
