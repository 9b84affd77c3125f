// rosrun matchbox_slam slam_node: the SLAM node without a nodelet manager.

#include <ros/ros.h>

#include <csignal>
#include <exception>

#include "matchbox_slam/common/options.hpp"
#include "node/slam_node.hpp"

int main(int argc, char** argv) {
  ros::init(argc, argv, "slam");
  // roscpp ends in good order on SIGINT alone; a SIGTERM, of systemd or docker stop, would cost the
  // trajectory.
  std::signal(SIGTERM, [](int /*signal*/) { ros::requestShutdown(); });
  // These outlive the node: with the last handle gone, ROS would not log what went wrong any more.
  const ros::NodeHandle node_handle;
  const ros::NodeHandle private_handle("~");
  try {
    const matchbox_slam::SlamNode node(node_handle, private_handle);
    ros::spin();
  } catch (const matchbox_slam::ConfigurationError& error) {
    ROS_FATAL_STREAM("slam_node: " << error.what());
    return 2;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("slam_node: " << error.what());
    return 1;
  }
  return 0;
}
