#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

/// Makes a node from the public and the private handle, and starts it.
using MakeNode =
    std::function<std::shared_ptr<void>(const ros::NodeHandle&, const ros::NodeHandle&)>;

/// main() of a program that is one node: serves it until SIGINT, SIGTERM or `rosnode kill`. On a
/// signal the node ends while ROS still works, so that its log lines are heard. Returns 0; 2 when
/// it cannot start for its configuration, and 1 for another reason, which the log tells.
/// @param options  which --help lists.
[[nodiscard]] int run_node(int argc, char** argv, const std::string& name,
                           const std::vector<OptionDescription>& options, const MakeNode& make);

}  // namespace matchbox_slam
