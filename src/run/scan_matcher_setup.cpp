#include "run/scan_matcher_setup.hpp"

#include <fmt/core.h>

#include "run/frames.hpp"
#include "run/setup_parts.hpp"

namespace matchbox_slam {

namespace {

GuessSource guess_source(const std::string& name) {
  if (name == "odometry") {
    return GuessSource::kOdometry;
  }
  return name == "imu" ? GuessSource::kHeading : GuessSource::kVelocity;
}

void check_frames(const ScanMatcherNodeOptions& options) {
  const auto refuse = [](const std::string& name, const std::string& value,
                         const std::string& text) {
    throw ConfigurationError(fmt::format("{}: '{}' is not allowed{}", name, value, text));
  };
  if (options.base_frame.empty()) {
    refuse("base_frame", "", "; allowed: the frame of the robot, such as base_link");
  }
  if (options.odom_frame.empty() || options.odom_frame == options.base_frame) {
    refuse("odom_frame", options.odom_frame, "; allowed: a frame other than base_frame");
  }
  if (options.guess != "odometry") {
    if (!options.guess_frame.empty()) {
      refuse(
          "guess_frame", options.guess_frame,
          fmt::format(" with guess '{}'; leave it out, or set guess to 'odometry'", options.guess));
    }
    return;
  }
  if (options.guess_frame.empty() || options.guess_frame == options.base_frame) {
    refuse("guess_frame", options.guess_frame,
           " with guess 'odometry'; allowed: the frame in which the odometry moves, such as odom");
  }
  if (options.publish_tf && options.guess_frame == options.odom_frame) {
    refuse("odom_frame", options.odom_frame,
           " with publish_tf, since it is guess_frame: its link to the base is another's already; "
           "allowed: a frame of its own, such as scan_odom, or publish_tf: false");
  }
}

std::vector<OptionDescription> describe_sections() {
  std::vector<OptionDescription> rows = describe_options(LaserOdometryOptions{});
  for (OptionDescription& row : rows) {
    row.name = "odometry/" + row.name;
  }
  for (const auto& section : {describe_cloud_options({}), describe_scan_timing_options({}),
                              describe_engine_options({})}) {
    rows.insert(rows.end(), section.begin(), section.end());
  }
  return rows;
}

}  // namespace

ScanMatcherSetup make_scan_matcher_setup(const Parameters& parameters,
                                         const MatcherCatalog& catalog) {
  ScanMatcherSetup setup;
  std::vector<std::string> names;
  setup.node = read_options_among<ScanMatcherNodeOptions>(parameters, "", names);
  const std::vector<std::string> matchers = reject_unknown_names(
      parameters, names,
      {"odometry", "scan", "cloud", "map", "field", "motion", "hypotheses", "recovery", "slam"},
      describe_sections(), catalog);
  for (std::string* frame :
       {&setup.node.base_frame, &setup.node.odom_frame, &setup.node.guess_frame}) {
    *frame = without_leading_slash(*frame);
  }
  check_frames(setup.node);
  setup.cloud = read_cloud_options(parameters);
  setup.timing = read_scan_timing_options(parameters);
  setup.guess = guess_source(setup.node.guess);
  setup.odometry = read_laser_odometry_settings(parameters);
  setup.matcher_name = catalog.find(setup.node.matcher);
  setup.matcher = make_matcher(parameters, catalog, setup.matcher_name, matchers);
  return setup;
}

}  // namespace matchbox_slam
