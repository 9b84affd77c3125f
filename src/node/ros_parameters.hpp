#pragma once

#include <XmlRpcValue.h>
#include <fmt/core.h>
#include <ros/node_handle.h>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// The parameters below a tree of the parameter server, by the same rules as YAML files: nested
/// names are joined with '/', a list of numbers is numbers, any other list text.
/// Throws ConfigurationError for values that are neither switch, number, text nor a list of these.
[[nodiscard]] Parameters to_parameters(const XmlRpc::XmlRpcValue& tree);

/// All private parameters of a node, without those that ROS itself reads (`diagnostic_period`).
[[nodiscard]] Parameters read_ros_parameters(const ros::NodeHandle& private_node);

/// What `read` makes of them. A ConfigurationError is thrown on with the command that takes the
/// parameter to blame off the parameter server, where it stays when the node has ended.
template <typename Read>
[[nodiscard]] auto from_ros_parameters(const ros::NodeHandle& private_node, const Read& read) {
  const Parameters all = read_ros_parameters(private_node);
  const auto complaint = [&](const std::string& left_out) -> std::string {
    Parameters parameters;
    for (const auto& [name, value] : all.values()) {
      if (name != left_out) {
        parameters.set(name, value);
      }
    }
    try {
      (void)read(parameters);
    } catch (const ConfigurationError& error) {
      return error.what();
    }
    return "";
  };
  try {
    return read(all);
  } catch (const ConfigurationError& error) {
    for (const auto& [name, value] : all.values()) {
      if (complaint(name) != error.what()) {
        std::string text = error.what();
        text.erase(text.find_last_not_of('.') + 1);
        throw ConfigurationError(
            fmt::format("{}; to take it off the parameter server: rosparam delete {}", text,
                        private_node.resolveName(name)));
      }
    }
    throw;
  }
}

}  // namespace matchbox_slam
