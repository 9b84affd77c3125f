#include "run/cloud_options.hpp"

#include <fmt/core.h>

#include <string>

namespace matchbox_slam {
namespace {

void check_order(const char* low_name, double low, const char* high_name, double high) {
  if (!(low < high)) {
    throw ConfigurationError(
        fmt::format("cloud/{}: {} is not allowed; allowed: less than cloud/{}, {}", low_name,
                    to_string(low), high_name, to_string(high)));
  }
}

}  // namespace

CloudOptions read_cloud_options(const Parameters& parameters) {
  constexpr double kSlack = 1e-6;  // of a turn that was written with few digits [rad]
  const auto options = read_options<CloudOptions>(parameters.section("cloud"), "cloud");
  check_order("min_height", options.min_height, "max_height", options.max_height);
  check_order("angle_min", options.angle_min, "angle_max", options.angle_max);
  check_order("range_min", options.range_min, "range_max", options.range_max);
  if (options.angle_max > options.angle_min + 2.0 * kPi + kSlack) {
    throw ConfigurationError(fmt::format(
        "cloud/angle_max: {} is not allowed; allowed: at most a turn after cloud/angle_min, {}",
        to_string(options.angle_max), to_string(options.angle_min + 2.0 * kPi)));
  }
  return options;
}

std::vector<OptionDescription> describe_cloud_options(const CloudOptions& options) {
  std::vector<OptionDescription> rows = describe_options(options);
  for (OptionDescription& row : rows) {
    row.name = "cloud/" + row.name;
  }
  return rows;
}

}  // namespace matchbox_slam
