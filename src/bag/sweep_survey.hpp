#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bag/bag_reader.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {

/// What the scans of a recording show of its lasers' sweeps, by laser, where messages tell what
/// cannot be: from the beginning of the recording, whatever part of it is asked for, until it is
/// known for good, as the robot has turned. So a map is drawn from its first scan on with what is
/// known later, and who maps it in pieces has the same for all of them. Ten minutes of scans have
/// to do. Ends early when interrupted, or where the bag is damaged.
/// Cost: of lasers whose messages tell what can be, ten scans; else that of reading the bag up to
/// there, and without odometry of matching its scans.
/// @param settings     as of who maps it.
/// @param scan_topics, imu_topic, cloud, odom_topic  as of BagReader::stream.
[[nodiscard]] std::map<int, ShownSweep> survey_sweeps(const BagReader& reader,
                                                      ScanQueueSettings settings,
                                                      const std::vector<std::string>& scan_topics,
                                                      const std::string& imu_topic,
                                                      const CloudOptions& cloud,
                                                      const std::string& odom_topic,
                                                      const std::function<bool()>& is_interrupted);

}  // namespace matchbox_slam
