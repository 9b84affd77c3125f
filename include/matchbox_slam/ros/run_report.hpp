#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "matchbox_slam/evaluation/error_statistics.hpp"
#include "matchbox_slam/ros/bag_scans.hpp"
#include "matchbox_slam/ros/resource_usage.hpp"
#include "matchbox_slam/ros/scan_queue.hpp"
#include "matchbox_slam/ros/slam_run.hpp"
#include "matchbox_slam/ros/slam_setup.hpp"

namespace matchbox_slam {

/// What a run on a bag used and yielded, besides the engine's own record.
struct RunFacts {
  BagFacts bag;
  std::size_t resets = 0;  ///< times that time jumped back and the map started anew
  ResourceUsage used;      ///< by this run
};

/// The report as JSON, for programs and people.
[[nodiscard]] std::string to_json(const RunFacts& facts, const ScanAccount& account,
                                  const SlamRun& run, const SlamSetup& setup);

/// Statistics of durations; all 0 when there are none.
[[nodiscard]] ErrorStatistics statistics_of(const std::vector<float>& values);

}  // namespace matchbox_slam
