#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/time.h>

#include <functional>
#include <string>

#include "ros/scan_message.hpp"

namespace matchbox_slam {

/// A scan as it came in.
struct ScanArrival {
  ScanMessage message;
  ros::Time time;  ///< by the clock of messages
};

/// Subscribes to a laser's topic with messages of any of the scan types: which one it is each
/// publisher tells when it connects. Laser scans of the same process come without a copy.
/// @param cloud  how clouds become scans.
[[nodiscard]] ros::Subscriber subscribe_to_scans(ros::NodeHandle& node, const std::string& topic,
                                                 const CloudOptions& cloud,
                                                 std::function<void(const ScanArrival&)> callback);

}  // namespace matchbox_slam
