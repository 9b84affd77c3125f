#pragma once

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// The flag of an option: `range_noise` is `--range-noise`.
[[nodiscard]] inline std::string flag_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name;
}

/// What --help says of an option: meaning, unit, what is allowed, and the default.
[[nodiscard]] inline std::string help_of(const OptionDescription& row) {
  const std::string unit = row.unit.empty() ? "" : fmt::format(" [{}]", row.unit);
  const std::string allowed = row.allowed.empty() ? "" : row.allowed + "; ";
  return fmt::format("{}{} ({}default {})", row.meaning, unit, allowed, to_string(row.value));
}

/// Adds a flag for every option of a struct. What is given goes to `given`, to be read with
/// read_options, so that flags have the defaults and limits of the struct. Switches are off unless
/// given.
template <typename Options>
void add_option_flags(CLI::App& app, const std::string& group, Parameters& given) {
  for (const OptionDescription& row : describe_options(Options{})) {
    const std::string name = row.name;
    if (std::holds_alternative<bool>(row.value)) {
      app.add_flag_function(
             flag_of(name), [&given, name](std::int64_t) { given.set(name, true); }, row.meaning)
          ->group(group);
    } else {
      app.add_option_function<std::string>(
             flag_of(name),
             [&given, name](const std::string& text) {
               given.set(name, parse_parameter_value(text));
             },
             help_of(row))
          ->group(group)
          ->type_name("VALUE");
    }
  }
}

}  // namespace matchbox_slam
