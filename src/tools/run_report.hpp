#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bag/bag_scans.hpp"
#include "ros/scan_account.hpp"
#include "run/resource_usage.hpp"
#include "run/slam_run.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// What a run on a bag used and yielded, besides the engine's own record.
struct RunFacts {
  BagFacts bag;
  std::size_t resets = 0;  ///< times that the map was given up
  ResourceUsage used;      ///< by this run
};

/// The report as JSON, for programs and people.
[[nodiscard]] std::string to_json(const RunFacts& facts, const ScanAccount& account,
                                  const SlamRun& run);

}  // namespace matchbox_slam
