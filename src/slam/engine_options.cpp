#include "matchbox_slam/slam/engine_options.hpp"

#include <string>
#include <utility>

#include "sensor/scan_timing.hpp"

namespace matchbox_slam {
namespace {

template <typename Options>
void append_section(const std::string& section, const Options& options,
                    std::vector<OptionDescription>& rows) {
  for (OptionDescription& row : describe_options(options)) {
    row.name = section + "/" + row.name;
    rows.push_back(std::move(row));
  }
}

}  // namespace

ProjectionOptions read_projection_options(const Parameters& parameters) {
  const Parameters section = parameters.section("scan");
  std::vector<std::string> known;
  auto options = read_options_among<ProjectionOptions>(section, "scan", known);
  for (const OptionDescription& row : describe_options(ScanTimingOptions{})) {
    known.push_back(row.name);  // of whoever has the messages
  }
  reject_unknown_keys(section, "scan", known);
  check_projection_options(options);
  return options;
}

EngineOptions read_engine_options(const Parameters& parameters) {
  EngineOptions options;
  options.slam = read_options<SlamOptions>(parameters.section("slam"), "slam");
  options.scan = read_projection_options(parameters);
  options.map = read_options<MapOptions>(parameters.section("map"), "map");
  options.field = read_options<LikelihoodFieldOptions>(parameters.section("field"), "field");
  options.motion = read_options<MotionPriorOptions>(parameters.section("motion"), "motion");
  options.hypotheses =
      read_options<HypothesisOptions>(parameters.section("hypotheses"), "hypotheses");
  options.recovery = read_options<RecoveryOptions>(parameters.section("recovery"), "recovery");
  options.loops = read_options<LoopOptions>(parameters.section("loops"), "loops");
  const double after_first_hit = 0.5 + 0.5 * options.map.quality;
  if (options.map.occupied_threshold > after_first_hit) {
    throw ConfigurationError(
        "map/occupied_threshold: " + to_string(options.map.occupied_threshold) +
        " is not allowed with a map/quality of " + to_string(options.map.quality) +
        ", since no first hit would reach it; allowed: at most " + to_string(after_first_hit));
  }
  return options;
}

std::vector<OptionDescription> describe_engine_options(const EngineOptions& options) {
  std::vector<OptionDescription> rows;
  append_section("slam", options.slam, rows);
  append_section("scan", options.scan, rows);
  append_section("map", options.map, rows);
  append_section("field", options.field, rows);
  append_section("motion", options.motion, rows);
  append_section("hypotheses", options.hypotheses, rows);
  append_section("recovery", options.recovery, rows);
  append_section("loops", options.loops, rows);
  return rows;
}

}  // namespace matchbox_slam
