#include "node/ros_parameters.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

namespace {

using XmlRpc::XmlRpcValue;

ParameterValue to_scalar(const std::string& name, const XmlRpcValue& value) {
  XmlRpcValue copy = value;  // conversions of older XmlRpc are not const
  switch (copy.getType()) {
    case XmlRpcValue::TypeBoolean:
      return static_cast<bool>(copy);
    case XmlRpcValue::TypeInt:
      return static_cast<std::int64_t>(static_cast<int>(copy));
    case XmlRpcValue::TypeDouble:
      return static_cast<double>(copy);
    case XmlRpcValue::TypeString:
      return static_cast<std::string>(copy);
    default:
      throw ConfigurationError(name +
                               ": the value is neither true or false, a number, a text, nor a "
                               "list of these");
  }
}

ParameterValue to_list(const std::string& name, const XmlRpcValue& value) {
  XmlRpcValue list = value;
  std::vector<double> numbers;
  std::vector<std::string> texts;
  // The iterators of XmlRpcValue are those of structs. NOLINTNEXTLINE(modernize-loop-convert)
  for (int i = 0; i < list.size(); ++i) {
    const ParameterValue element = to_scalar(name, list[i]);
    if (const std::optional<double> number = number_in(element)) {
      numbers.push_back(*number);
    }
    const auto* text = std::get_if<std::string>(&element);
    texts.push_back(text != nullptr ? *text : to_string(element));
  }
  if (numbers.size() == texts.size()) {
    return numbers;
  }
  return texts;
}

void add_tree(const std::string& prefix, const XmlRpcValue& value, Parameters& parameters) {
  XmlRpcValue tree = value;
  for (auto& [key, member] : tree) {
    const std::string name = prefix.empty() ? key : fmt::format("{}/{}", prefix, key);
    if (member.getType() == XmlRpcValue::TypeStruct) {
      add_tree(name, member, parameters);
    } else if (member.getType() == XmlRpcValue::TypeArray) {
      parameters.set(name, to_list(name, member));
    } else {
      parameters.set(name, to_scalar(name, member));
    }
  }
}

}  // namespace

Parameters to_parameters(const XmlRpc::XmlRpcValue& tree) {
  Parameters parameters;
  if (tree.getType() == XmlRpcValue::TypeStruct) {
    add_tree("", tree, parameters);
  }
  return parameters;
}

Parameters read_ros_parameters(const ros::NodeHandle& private_node) {
  XmlRpcValue tree;
  Parameters own;
  if (private_node.getParam(private_node.getNamespace(), tree)) {
    const Parameters all = to_parameters(tree);
    for (const auto& [key, value] : all.values()) {
      if (key != "diagnostic_period") {
        own.set(key, value);
      }
    }
  }
  return own;
}

}  // namespace matchbox_slam
