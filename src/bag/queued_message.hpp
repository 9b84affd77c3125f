#pragma once

#include <string>

#include "bag/bag_reader.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {

/// A message of a bag goes into the queue. Returns what is wrong with one of odometry or an IMU, as
/// the queue tells it, for people; empty: nothing.
std::string add_message(const BagMessage& message, ScanQueue& queue);

}  // namespace matchbox_slam
