#pragma once

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <string>
#include <utility>
#include <vector>

#include "run/cloud_options.hpp"

namespace matchbox_slam {

/// What a laser's message of any type tells, as a scan of one plane.
struct ScanMessage {
  sensor_msgs::LaserScan::ConstPtr scan;  ///< with a defect, of the message's header alone
  std::string defect;  ///< why there is no scan in it, for people; empty: there is one, which may
                       ///< have defects of its own
  bool is_empty = false;   ///< the defect is that it holds nothing
  bool has_times = false;  ///< those of its beams are told by whoever reads it, not by a driver
};

/// Names of the types of messages that are read as scans, the one to be preferred first.
[[nodiscard]] const std::vector<std::string>& scan_types();
[[nodiscard]] bool is_scan_type(const std::string& type);

[[nodiscard]] inline ScanMessage to_scan(sensor_msgs::LaserScan::ConstPtr message) {
  return {std::move(message), {}, false};
}

/// The first echo of each beam; a beam without any is ignored.
[[nodiscard]] ScanMessage to_scan(const sensor_msgs::MultiEchoLaserScan& message);

/// The nearest point of each beam, among those of one ring or of a band of heights, in the frame of
/// the cloud: its distance along the plane and, as for its direction, the middle of the beam.
[[nodiscard]] ScanMessage to_scan(const sensor_msgs::PointCloud2& message,
                                  const CloudOptions& options);

}  // namespace matchbox_slam
