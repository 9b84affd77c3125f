#pragma once

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// The parameters below a tree of the parameter server, by the same rules as YAML files: nested
/// names are joined with '/', a list of numbers is numbers, any other list text.
/// Throws ConfigurationError for values that are neither switch, number, text nor a list of these.
[[nodiscard]] Parameters to_parameters(const XmlRpc::XmlRpcValue& tree);

/// All private parameters of a node, without those that ROS itself reads (`diagnostic_period`).
[[nodiscard]] Parameters read_ros_parameters(const ros::NodeHandle& private_node);

}  // namespace matchbox_slam
