#include "sensor/scan_timing.hpp"

#include <cmath>
#include <variant>
#include <vector>

#include "common/number_text.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLongestSweep = 10.0;  // s
constexpr double kMostParts = 1000.0;

SweepTimeSetting sweep_time_of(const std::string& text) {
  const std::optional<double> seconds = finite_number(text);
  if (text == "auto") {
    return {};
  }
  if (text == "as_sent") {
    return {true, std::nullopt};
  }
  if (!seconds || *seconds < 0.0 || *seconds > kLongestSweep) {
    throw ConfigurationError("scan/sweep_time: " + text +
                             " is not allowed; allowed: auto, as_sent, or a number of seconds "
                             "from 0 to 10");
  }
  return {false, seconds};
}

std::optional<int> join_parts_of(const std::string& text) {
  if (text == "auto") {
    return std::nullopt;
  }
  const std::optional<double> number = finite_number(text);
  if (!number || *number != std::floor(*number) || *number < 1.0 || *number > kMostParts) {
    throw ConfigurationError("scan/join_parts: " + text +
                             " is not allowed; allowed: auto, or the number of scans that are one "
                             "turn, from 1 to 1000");
  }
  return static_cast<int>(*number);
}

/// YAML takes what is none of their words for a number.
Parameters with_texts(Parameters section) {
  for (const OptionDescription& row : describe_options(ScanTimingOptions{})) {
    const ParameterValue* value = section.find(row.name);
    if (value != nullptr && !std::holds_alternative<std::string>(*value)) {
      section.set(row.name, to_string(*value));
    }
  }
  return section;
}

}  // namespace

ScanTiming scan_timing(const ScanTimingOptions& options) {
  return {sweep_time_of(options.sweep_time), join_parts_of(options.join_parts)};
}

ScanTimingOptions read_scan_timing_options(const Parameters& parameters) {
  std::vector<std::string> known;
  auto options =
      read_options_among<ScanTimingOptions>(with_texts(parameters.section("scan")), "scan", known);
  static_cast<void>(scan_timing(options));  // throws
  return options;
}

std::vector<OptionDescription> describe_scan_timing_options(const ScanTimingOptions& options) {
  std::vector<OptionDescription> rows = describe_options(options);
  for (OptionDescription& row : rows) {
    row.name = "scan/" + row.name;
  }
  return rows;
}

}  // namespace matchbox_slam
