#include "node/node_program.hpp"

#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <csignal>
#include <exception>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

volatile std::sig_atomic_t signalled = 0;  // a handler of signals reaches nothing else

}  // namespace

int run_node(int argc, char** argv, const std::string& name, const MakeNode& make) {
  ros::init(argc, argv, name);
  // While the node starts it may wait for a master, which only roscpp's own way of ending ends;
  // that heeds SIGINT alone.
  std::signal(SIGTERM, [](int /*signal*/) { ros::requestShutdown(); });
  // These outlive the node: with the last handle gone, ROS would not log what went wrong any more.
  const ros::NodeHandle node_handle;
  const ros::NodeHandle private_handle("~");
  try {
    const std::shared_ptr<void> node = make(node_handle, private_handle);
    for (const int signal : {SIGINT, SIGTERM}) {
      std::signal(signal, [](int /*signal*/) { signalled = 1; });
    }
    while (ros::ok() && signalled == 0) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
    }
  } catch (const ConfigurationError& error) {
    ROS_FATAL_STREAM(name << ": " << error.what());
    return 2;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(name << ": " << error.what());
    return 1;
  }
  return 0;
}

}  // namespace matchbox_slam
