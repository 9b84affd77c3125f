#include "bag/queued_message.hpp"

#include <variant>

namespace matchbox_slam {

std::string add_message(const BagMessage& message, ScanQueue& queue) {
  if (const auto* transforms = std::get_if<BagTransforms>(&message.content)) {
    queue.add_transforms(*transforms->message, transforms->is_static, message.time);
    return {};
  }
  if (const auto* imu = std::get_if<sensor_msgs::Imu::ConstPtr>(&message.content)) {
    return queue.add_imu(**imu, message.time);
  }
  if (const auto* odometry = std::get_if<nav_msgs::Odometry::ConstPtr>(&message.content)) {
    return queue.add_odometry(**odometry, message.time);
  }
  queue.add_scan(std::get<ScanMessage>(message.content), message.time, message.laser);
  return {};
}

}  // namespace matchbox_slam
