#pragma once

#include "ros/scan_queue.hpp"
#include "run/run_options.hpp"
#include "run/scan_matcher_setup.hpp"

namespace matchbox_slam {

/// How the queue is to be set up for a configuration.
/// @param projection        as the scans are projected afterwards.
/// @param scan_time_offset  [s], what 'auto' has come to.
[[nodiscard]] ScanQueueSettings queue_settings(const RunOptions& options,
                                               const ProjectionOptions& projection,
                                               const ScanTimingOptions& timing,
                                               double scan_time_offset);

/// How the queue of scans is to be set up. An IMU's heading comes as a link of tf, from
/// kImuHeadingFrame, so that scans wait for it as they do for odometry.
[[nodiscard]] ScanQueueSettings queue_settings(const ScanMatcherSetup& setup);

}  // namespace matchbox_slam
