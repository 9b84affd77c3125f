#pragma once

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "tools/recording_request.hpp"

namespace matchbox_slam {

/// An option that may be given several times, one value each, so that it takes no bag for a value.
void add_repeated(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                  const std::string& help, const std::string& type_name);

/// An option that takes a number, which is refused in the words that parameters have.
template <typename Number, typename Value>
void add_number(CLI::App& app, const std::string& name, Value& value, const Allowed& allowed,
                const std::string& help, const std::string& type_name = "N") {
  CLI::Option* option = app.add_option_function<std::string>(
      name,
      [name, allowed, &value](const std::string& text) {
        Number number{};
        read_value(parse_parameter_value(text), name, allowed, number);
        value = number;
      },
      help);
  option->type_name(type_name);
  if constexpr (std::is_arithmetic_v<Value>) {
    option->default_str(std::isfinite(static_cast<double>(value)) ? fmt::format("{}", value) : "");
  }
}

/// The flags that say which scans of a recording to read, all but the bags themselves.
void add_bag_flags(CLI::App& app, BagRequest& request);

/// The flags for a RecordingRequest. @param seed_help, debug_help  what these two are about.
void add_recording_flags(CLI::App& app, RecordingRequest& request, const std::string& seed_help,
                         const std::string& debug_help);

}  // namespace matchbox_slam
