#include "node/subscribe.hpp"

#include <ros/console.h>
#include <sensor_msgs/Imu.h>

namespace matchbox_slam {

ros::Subscriber subscribe_to_imu(ros::NodeHandle& node, const std::string& topic,
                                 ScanWorker& worker) {
  constexpr double kWarningInterval = 10.0;  // s
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
