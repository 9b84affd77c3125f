#include "ros/scan_message.hpp"

#include <ros/message_traits.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <limits>

namespace matchbox_slam {

const std::vector<std::string>& scan_types() {
  static const std::vector<std::string> kTypes = {
      ros::message_traits::datatype<sensor_msgs::LaserScan>(),
      ros::message_traits::datatype<sensor_msgs::MultiEchoLaserScan>(),
      ros::message_traits::datatype<sensor_msgs::PointCloud2>()};
  return kTypes;
}

bool is_scan_type(const std::string& type) {
  return std::find(scan_types().begin(), scan_types().end(), type) != scan_types().end();
}

ScanMessage to_scan(const sensor_msgs::MultiEchoLaserScan& message) {
  const auto scan = boost::make_shared<sensor_msgs::LaserScan>();
  scan->header = message.header;
  scan->angle_min = message.angle_min;
  scan->angle_max = message.angle_max;
  scan->angle_increment = message.angle_increment;
  scan->time_increment = message.time_increment;
  scan->scan_time = message.scan_time;
  scan->range_min = message.range_min;
  scan->range_max = message.range_max;
  scan->ranges.reserve(message.ranges.size());
  for (const sensor_msgs::LaserEcho& beam : message.ranges) {
    scan->ranges.push_back(beam.echoes.empty() ? std::numeric_limits<float>::quiet_NaN()
                                               : beam.echoes.front());
  }
  return {scan, {}, false};
}

}  // namespace matchbox_slam
