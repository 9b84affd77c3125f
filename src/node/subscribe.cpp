#include "node/subscribe.hpp"

#include <nav_msgs/Odometry.h>
#include <ros/console.h>
#include <sensor_msgs/Imu.h>

namespace matchbox_slam {
namespace {

constexpr double kWarningInterval = 10.0;  // s

}  // namespace

ros::Subscriber subscribe_to_odometry(ros::NodeHandle& node, const std::string& topic,
                                      ScanWorker& worker) {
  return subscribe_to_events<nav_msgs::Odometry>(
      node, topic, kTransformMessages,
      [&worker](const ros::MessageEvent<const nav_msgs::Odometry>& event) {
        std::string defect;
        worker.use_queue([&](ScanQueue& queue) {
          defect = queue.add_odometry(*event.getConstMessage(), event.getReceiptTime());
        });
        if (!defect.empty()) {
          ROS_WARN_STREAM_THROTTLE(kWarningInterval, "a message of odometry by "
                                                         << event.getPublisherName()
                                                         << " is ignored: " << defect);
        }
      });
}

ros::Subscriber subscribe_to_imu(ros::NodeHandle& node, const std::string& topic,
                                 ScanWorker& worker) {
  return subscribe_to_events<sensor_msgs::Imu>(
      node, topic, kTransformMessages,
      [&worker](const ros::MessageEvent<const sensor_msgs::Imu>& event) {
        std::string defect;
        worker.use_queue([&](ScanQueue& queue) {
          defect = queue.add_imu(*event.getConstMessage(), event.getReceiptTime());
        });
        if (!defect.empty()) {
          ROS_WARN_STREAM_THROTTLE(kWarningInterval, "an IMU's message is ignored: " << defect);
        }
      });
}

}  // namespace matchbox_slam
