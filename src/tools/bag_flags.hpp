#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bag/bag_scans.hpp"

namespace matchbox_slam {

/// An option whose value stays unset unless it is given.
template <typename Value>
CLI::Option* add_optional(CLI::App& app, const std::string& name, std::optional<Value>& value,
                          const std::string& help, const std::string& type_name) {
  CLI::Option* option = app.add_option_function<Value>(
      name, [&value](const Value& given) { value = given; }, help);
  return option->type_name(type_name);
}

/// An option that may be given several times, one value each, so that it takes no bag for a value.
CLI::Option* add_repeated(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                          const std::string& help, const std::string& type_name);

/// The flags that say which scans of a recording to read, all but the bags themselves.
void add_bag_flags(CLI::App& app, BagRequest& request);

}  // namespace matchbox_slam
