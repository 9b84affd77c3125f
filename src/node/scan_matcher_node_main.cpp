// rosrun matchbox_slam scan_matcher_node: laser odometry without a nodelet manager.

#include <ros/ros.h>

#include <csignal>
#include <exception>

#include "matchbox_slam/common/options.hpp"
#include "node/scan_matcher_node.hpp"

int main(int argc, char** argv) {
  ros::init(argc, argv, "scan_matcher");
  // roscpp ends in good order on SIGINT alone.
  std::signal(SIGTERM, [](int /*signal*/) { ros::requestShutdown(); });
  // These outlive the node: with the last handle gone, ROS would not log what went wrong any more.
  const ros::NodeHandle node_handle;
  const ros::NodeHandle private_handle("~");
  try {
    const matchbox_slam::ScanMatcherNode node(node_handle, private_handle);
    ros::spin();
  } catch (const matchbox_slam::ConfigurationError& error) {
    ROS_FATAL_STREAM("scan_matcher_node: " << error.what());
    return 2;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("scan_matcher_node: " << error.what());
    return 1;
  }
  return 0;
}
