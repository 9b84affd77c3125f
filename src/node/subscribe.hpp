#pragma once

#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <boost/function.hpp>
#include <cstdint>
#include <string>

#include "node/scan_worker.hpp"

namespace matchbox_slam {

/// Subscribes to messages with what came with them: publisher and time of arrival. A lambda that is
/// handed to roscpp itself would be called with events that know neither.
template <typename Message>
[[nodiscard]] ros::Subscriber subscribe_to_events(
    ros::NodeHandle& node, const std::string& topic, std::uint32_t queue_size,
    const boost::function<void(const ros::MessageEvent<const Message>&)>& callback) {
  return node.subscribe<Message>(topic, queue_size, callback, ros::VoidConstPtr(),
                                 ros::TransportHints().tcpNoDelay());
}

/// Subscribes to nav_msgs/Odometry and puts its poses into the worker's queue; warns of those that
/// are ignored.
[[nodiscard]] ros::Subscriber subscribe_to_odometry(ros::NodeHandle& node, const std::string& topic,
                                                    ScanWorker& worker);

/// Subscribes to an IMU's messages and puts them into the worker's queue; warns of those that are
/// ignored.
[[nodiscard]] ros::Subscriber subscribe_to_imu(ros::NodeHandle& node, const std::string& topic,
                                               ScanWorker& worker);

}  // namespace matchbox_slam
