#include "matchbox_slam/ros/slam_setup.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "matchbox_slam/ros/transform_store.hpp"

namespace matchbox_slam {

namespace {

template <typename Options>
std::vector<std::string> option_names() {
  std::vector<std::string> names;
  for (const OptionDescription& row : describe_options(Options{})) {
    names.push_back(row.name);
  }
  return names;
}

/// The values of the given names; those of others are left out.
Parameters only(const Parameters& parameters, const std::vector<std::string>& names) {
  Parameters selected;
  for (const std::string& name : names) {
    if (const ParameterValue* value = parameters.find(name)) {
      selected.set(name, *value);
    }
  }
  return selected;
}

/// Looks at the first part of every key: an option of the run or the node, or a section.
void reject_unknown_names(const Parameters& parameters, const MatcherLoader& loader) {
  std::vector<std::string> options = option_names<RunOptions>();
  for (const std::string& name : option_names<SlamNodeOptions>()) {
    options.push_back(name);
  }
  std::vector<std::string> sections = {"slam", "scan", "map", "field", "motion"};
  for (const std::string& lookup_name : loader.lookup_names()) {
    sections.push_back(matcher_short_name(lookup_name));
  }
  Parameters names_in_sections;
  Parameters plain_names;
  for (const auto& [key, value] : parameters.values()) {
    const std::size_t slash = key.find('/');
    (slash == std::string::npos ? plain_names : names_in_sections).set(key.substr(0, slash), value);
  }
  reject_unknown_keys(plain_names, "", options);
  reject_unknown_keys(names_in_sections, "sections", sections);
}

/// Configures the matchers that have a section but are not in use, so that a slip there is told now
/// and not on the day they are chosen.
void check_other_matchers(const Parameters& parameters, const MatcherLoader& loader,
                          const std::string& in_use) {
  for (const std::string& lookup_name : loader.lookup_names()) {
    const std::string section = matcher_short_name(lookup_name);
    const Parameters options = parameters.section(section);
    if (section != in_use && !options.values().empty()) {
      loader.create(lookup_name)->configure(options);
    }
  }
}

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
  const bool is_in_range = offset && std::abs(*offset) <= kLargestOffset;  // nan is not
  if (options.scan_time_offset != "auto" && !is_in_range) {
    throw ConfigurationError("scan_time_offset: " + options.scan_time_offset +
                             " is not allowed; allowed: a number of seconds from -1000000 to "
                             "1000000, auto");
  }
}

/// Frames as tf2 wants them.
void strip_leading_slashes(RunOptions& options) {
  for (std::string* frame : {&options.base_frame, &options.odom_frame, &options.map_frame}) {
    *frame = without_leading_slash(*frame);
  }
}

}  // namespace

std::optional<double> fixed_scan_time_offset(const RunOptions& options) {
  const ParameterValue value = parse_parameter_value(options.scan_time_offset);
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    return static_cast<double>(*whole);
  }
  if (const auto* real = std::get_if<double>(&value)) {
    return *real;
  }
  return std::nullopt;
}

void check_frames(const RunOptions& options) {
  std::map<std::string, std::string> names;
  const auto add = [&](const std::string& frame, const std::string& name) {
    const auto [other, is_new] = names.emplace(frame, name);
    if (!is_new && !frame.empty()) {
      throw ConfigurationError(name + ": '" + frame +
                               "' is not allowed; allowed: a frame other than " + other->second);
    }
  };
  add(options.map_frame, "map_frame");
  add(options.base_frame, "base_frame");
  if (options.use_odometry) {
    add(options.odom_frame, "odom_frame");
  }
}

SlamSetup make_slam_setup(const Parameters& parameters, const MatcherLoader& loader) {
  reject_unknown_names(parameters, loader);
  SlamSetup setup;
  setup.run = read_options<RunOptions>(
      with_offset_as_text(only(parameters, option_names<RunOptions>())), "");
  check_scan_time_offset(setup.run);
  strip_leading_slashes(setup.run);
  setup.node = read_options<SlamNodeOptions>(only(parameters, option_names<SlamNodeOptions>()), "");
  setup.engine = read_engine_options(parameters);
  setup.matcher_name = loader.find(setup.run.matcher);
  const std::shared_ptr<ScanMatcher> matcher = loader.create(setup.matcher_name);
  const std::string section = matcher_short_name(setup.matcher_name);
  matcher->configure(parameters.section(section));
  setup.matcher = matcher;
  setup.hough = read_options<HoughOptions>(parameters.section("hough"), "hough");
  check_other_matchers(parameters, loader, section);
  return setup;
}

std::vector<OptionDescription> describe_setup(const SlamSetup& setup) {
  std::vector<OptionDescription> rows = describe_options(setup.run);
  for (OptionDescription& row : describe_engine_options(setup.engine)) {
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
