#include "run/slam_setup.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/number_text.hpp"
#include "run/frames.hpp"
#include "run/setup_parts.hpp"

namespace matchbox_slam {

namespace {

/// YAML types an offset such as 82.2 as a number, but it may be the word 'auto' too.
Parameters with_offset_as_text(Parameters parameters) {
  const ParameterValue* offset = parameters.find("scan_time_offset");
  if (offset != nullptr && !std::holds_alternative<std::string>(*offset)) {
    parameters.set("scan_time_offset", to_string(*offset));
  }
  return parameters;
}

/// A command line gives a list of numbers as text, such as 0.2,0,0 or [0.2, 0, 0].
Parameters with_laser_pose_as_list(Parameters parameters) {
  const ParameterValue* pose = parameters.find("laser_pose");
  const auto* text = pose == nullptr ? nullptr : std::get_if<std::string>(pose);
  if (text == nullptr) {
    return parameters;
  }
  std::string bare;
  std::remove_copy_if(text->begin(), text->end(), std::back_inserter(bare),
                      [](char c) { return c == '[' || c == ']' || c == ' '; });
  std::vector<double> numbers;
  for (const std::string& word : bare.empty() ? std::vector<std::string>{} : split(bare, ',')) {
    const std::optional<double> number = finite_number(word);
    if (!number) {
      throw ConfigurationError(fmt::format(
          "laser_pose: '{}' is not allowed; allowed: [x, y, yaw] in m and rad, such as 0.2,0,3.14",
          *text));
    }
    numbers.push_back(*number);
  }
  parameters.set("laser_pose", numbers);
  return parameters;
}

void check_laser_pose(const RunOptions& options) {
  const std::size_t numbers = options.laser_pose.size();
  const std::size_t lasers = std::max<std::size_t>(1, options.scan_topics.size());
  if (numbers % 3 != 0) {
    throw ConfigurationError(fmt::format(
        "laser_pose: {} numbers are not allowed; allowed: three for each laser: x, y, yaw",
        numbers));
  }
  // Where no topic is named yet, several may be found.
  if (!options.scan_topics.empty() && numbers / 3 > lasers) {
    throw ConfigurationError(fmt::format(
        "laser_pose: {} places are not allowed; there are {} scan_topics", numbers / 3, lasers));
  }
}

void check_odom_topic(const RunOptions& options) {
  if (!options.odom_topic.empty() && !options.use_odometry) {
    throw ConfigurationError(
        fmt::format("odom_topic: '{}' is not allowed without odometry (use_odometry false, "
                    "--no-odom); leave out one of the two",
                    options.odom_topic));
  }
}

void check_scan_time_offset(const RunOptions& options) {
  constexpr double kLargestOffset = 1e6;  // s
  const std::optional<double> offset = fixed_scan_time_offset(options);
  const bool is_in_range = offset && std::abs(*offset) <= kLargestOffset;
  if (options.scan_time_offset != "auto" && !is_in_range) {
    throw ConfigurationError(
        fmt::format("scan_time_offset: {} is not allowed; allowed: a number of seconds from "
                    "-1000000 to 1000000, auto",
                    options.scan_time_offset));
  }
}

std::vector<OptionDescription> describe_sections(const CloudOptions& cloud,
                                                 const ScanTimingOptions& timing,
                                                 const EngineOptions& engine) {
  std::vector<OptionDescription> rows = describe_cloud_options(cloud);
  for (OptionDescription& row : describe_scan_timing_options(timing)) {
    rows.push_back(std::move(row));
  }
  for (OptionDescription& row : describe_engine_options(engine)) {
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Frames as tf2 wants them.
void strip_leading_slashes(RunOptions& options) {
  for (std::string* frame : {&options.base_frame, &options.odom_frame, &options.map_frame}) {
    *frame = without_leading_slash(*frame);
  }
}

}  // namespace

std::optional<double> fixed_scan_time_offset(const RunOptions& options) {
  return finite_number(options.scan_time_offset);
}

MapFormat map_format(const RunOptions& options) {
  return options.map_format == "png" ? MapFormat::kPng : MapFormat::kPgm;
}

SlamSetup make_slam_setup(const Parameters& parameters, const MatcherCatalog& catalog,
                          SetupOf whose) {
  SlamSetup setup;
  std::vector<std::string> names;
  setup.run = read_options_among<RunOptions>(
      with_laser_pose_as_list(with_offset_as_text(parameters)), "", names);
  if (whose == SetupOf::kNode) {
    setup.node = read_options_among<SlamNodeOptions>(parameters, "", names);
  }
  const std::vector<std::string> matchers = reject_unknown_names(
      parameters, names,
      {"slam", "scan", "cloud", "map", "field", "motion", "hypotheses", "recovery", "loops"},
      describe_sections({}, {}, {}), catalog);
  check_scan_time_offset(setup.run);
  check_laser_pose(setup.run);
  check_odom_topic(setup.run);
  strip_leading_slashes(setup.run);
  setup.cloud = read_cloud_options(parameters);
  setup.timing = read_scan_timing_options(parameters);
  setup.engine = read_engine_options(parameters);
  setup.matcher_name = catalog.find(setup.run.matcher);
  setup.matcher = make_matcher(parameters, catalog, setup.matcher_name, matchers);
  setup.hough = read_options<HoughOptions>(parameters.section("hough"), "hough");
  return setup;
}

std::vector<OptionDescription> describe_setup(const SlamSetup& setup) {
  std::vector<OptionDescription> rows = describe_options(setup.run);
  for (OptionDescription& row : describe_sections(setup.cloud, setup.timing, setup.engine)) {
    rows.push_back(std::move(row));
  }
  const std::string section = matcher_short_name(setup.matcher_name);
  for (OptionDescription& row : setup.matcher->options()) {
    row.name = fmt::format("{}/{}", section, row.name);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace matchbox_slam
