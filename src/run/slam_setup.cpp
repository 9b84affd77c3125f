#include "run/slam_setup.hpp"

#include <cmath>
#include <utility>

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

void check_scan_time_offset(const RunOptions& options) {
  constexpr double kLargestOffset = 1e6;  // s
  const std::optional<double> offset = fixed_scan_time_offset(options);
  const bool is_in_range = offset && std::abs(*offset) <= kLargestOffset;
  if (options.scan_time_offset != "auto" && !is_in_range) {
    throw ConfigurationError("scan_time_offset: " + options.scan_time_offset +
                             " is not allowed; allowed: a number of seconds from -1000000 to "
                             "1000000, auto");
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
  setup.run = read_options_among<RunOptions>(with_offset_as_text(parameters), "", names);
  if (whose == SetupOf::kNode) {
    setup.node = read_options_among<SlamNodeOptions>(parameters, "", names);
  }
  reject_unknown_names(
      parameters, names,
      {"slam", "scan", "cloud", "map", "field", "motion", "hypotheses", "recovery", "loops"},
      describe_sections({}, {}, {}), catalog);
  check_scan_time_offset(setup.run);
  strip_leading_slashes(setup.run);
  setup.cloud = read_cloud_options(parameters);
  setup.timing = read_scan_timing_options(parameters);
  setup.engine = read_engine_options(parameters);
  setup.matcher_name = catalog.find(setup.run.matcher);
  setup.matcher = make_matcher(parameters, catalog, setup.matcher_name);
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
    row.name = section + "/" + row.name;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace matchbox_slam
