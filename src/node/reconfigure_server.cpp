#include "node/reconfigure_server.hpp"

#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/config_tools.h>
#include <fmt/core.h>
#include <ros/console.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>

namespace matchbox_slam {

namespace {

/// Lists have no place among the types of dynamic_reconfigure.
bool is_single_value(const ParameterValue& value) {
  return !std::holds_alternative<std::vector<double>>(value) &&
         !std::holds_alternative<std::vector<std::string>>(value);
}

/// Lists are left out.
void add_value(const std::string& name, const ParameterValue& value,
               dynamic_reconfigure::Config& config) {
  using dynamic_reconfigure::ConfigTools;
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    ConfigTools::appendParameter(config, name, static_cast<int>(*whole));
  } else if (const auto* flag = std::get_if<bool>(&value)) {
    ConfigTools::appendParameter(config, name, *flag);
  } else if (const auto* real = std::get_if<double>(&value)) {
    ConfigTools::appendParameter(config, name, *real);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    ConfigTools::appendParameter(config, name, *text);
  }
}

dynamic_reconfigure::Config empty_config() {
  dynamic_reconfigure::Config config;
  dynamic_reconfigure::GroupState group;
  group.name = "Default";
  group.state = 1;
  config.groups.push_back(group);
  return config;
}

dynamic_reconfigure::Config values_of(const std::vector<OptionDescription>& options) {
  dynamic_reconfigure::Config config = empty_config();
  for (const OptionDescription& option : options) {
    add_value(option.name, option.value, config);
  }
  return config;
}

const char* type_of(const ParameterValue& value) {
  if (std::holds_alternative<bool>(value)) {
    return "bool";
  }
  if (std::holds_alternative<std::int64_t>(value)) {
    return "int";
  }
  return std::holds_alternative<double>(value) ? "double" : "str";
}

/// The words of an option as Python reads them, which is what the protocol asks for.
std::string edit_method(const std::vector<std::string>& words) {
  if (words.empty()) {
    return "";
  }
  std::string entries;
  for (const std::string& word : words) {
    entries += fmt::format(
        "{}{{'name': '{}', 'type': 'str', 'value': '{}', 'description': '', 'srcline': 0, "
        "'srcfile': '', 'cconsttype': 'const char * const', 'ctype': 'std::string'}}",
        entries.empty() ? "" : ", ", word, word);
  }
  return fmt::format("{{'enum_description': '', 'enum': [{}]}}", entries);
}

/// A limit of an option: as wide as its type allows where there is none.
ParameterValue limit_of(const OptionDescription& option, bool highest) {
  const double limit = highest ? option.limits.high : option.limits.low;
  if (std::holds_alternative<std::int64_t>(option.value)) {
    constexpr double kLargest = std::numeric_limits<std::int32_t>::max();
    return static_cast<std::int64_t>(std::clamp(limit, -kLargest, kLargest));
  }
  if (std::holds_alternative<double>(option.value)) {
    return limit;
  }
  return std::holds_alternative<bool>(option.value) ? ParameterValue(highest)
                                                    : ParameterValue(std::string());
}

dynamic_reconfigure::ConfigDescription describe(const std::vector<OptionDescription>& options) {
  dynamic_reconfigure::ConfigDescription description;
  dynamic_reconfigure::Group group;
  group.name = "Default";
  description.min = empty_config();
  description.max = empty_config();
  for (const OptionDescription& option : options) {
    dynamic_reconfigure::ParamDescription row;
    row.name = option.name;
    row.type = type_of(option.value);
    row.description =
        option.meaning + (option.unit.empty() ? "" : fmt::format(" [{}]", option.unit));
    row.edit_method = edit_method(option.limits.words);
    group.parameters.push_back(row);
    add_value(option.name, limit_of(option, false), description.min);
    add_value(option.name, limit_of(option, true), description.max);
  }
  description.groups.push_back(group);
  description.dflt = values_of(options);
  return description;
}

Parameters to_parameters(const dynamic_reconfigure::Config& config) {
  Parameters parameters;
  for (const auto& entry : config.bools) {
    parameters.set(entry.name, entry.value != 0);
  }
  for (const auto& entry : config.ints) {
    parameters.set(entry.name, std::int64_t{entry.value});
  }
  for (const auto& entry : config.doubles) {
    parameters.set(entry.name, entry.value);
  }
  for (const auto& entry : config.strs) {
    parameters.set(entry.name, entry.value);
  }
  return parameters;
}

std::vector<OptionDescription> single_values(std::vector<OptionDescription> options) {
  options.erase(std::remove_if(options.begin(), options.end(),
                               [](const auto& row) { return !is_single_value(row.value); }),
                options.end());
  return options;
}

}  // namespace

ReconfigureServer::ReconfigureServer(const ros::NodeHandle& private_node,
                                     const std::vector<OptionDescription>& options, Change change)
    : private_node_(private_node),
      change_(std::move(change)),
      values_(values_of(options)),
      descriptions_(private_node_.advertise<dynamic_reconfigure::ConfigDescription>(
          "parameter_descriptions", 1, true)),
      updates_(private_node_.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, true)),
      service_(private_node_.advertiseService("set_parameters", &ReconfigureServer::answer, this)) {
  descriptions_.publish(describe(single_values(options)));
  updates_.publish(values_);
}

bool ReconfigureServer::answer(dynamic_reconfigure::Reconfigure::Request& request,
                               dynamic_reconfigure::Reconfigure::Response& response) {
  std::string refusal;
  try {
    values_ = values_of(change_(to_parameters(request.config)));
    keep_on_parameter_server(request.config);
    updates_.publish(values_);
  } catch (const std::exception& error) {
    refusal = error.what();
    ROS_ERROR_STREAM("not changed: " << refusal);
  }
  response.config = values_;
  if (!refusal.empty()) {  // the protocol has no place for it but among the values
    dynamic_reconfigure::ConfigTools::appendParameter(response.config, "refused", refusal);
  }
  return true;
}

/// Whoever restarts the node then gets what was chosen. What was not touched is left alone:
/// defaults on the parameter server would outlive the configuration file that they came from.
void ReconfigureServer::keep_on_parameter_server(const dynamic_reconfigure::Config& config) {
  const Parameters parameters = to_parameters(config);
  for (const auto& [name, value] : parameters.values()) {
    const std::string& key = name;  // what is bound by name no lambda captures
    std::visit(
        [&](const auto& single) {
          if constexpr (std::is_same_v<std::decay_t<decltype(single)>, std::int64_t>) {
            private_node_.setParam(key, static_cast<int>(single));
          } else {
            private_node_.setParam(key, single);
          }
        },
        value);
  }
}

}  // namespace matchbox_slam
