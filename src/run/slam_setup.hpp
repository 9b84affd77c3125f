#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/cloud_options.hpp"
#include "run/matcher_catalog.hpp"
#include "run/run_options.hpp"
#include "run/slam_node_options.hpp"
#include "sensor/scan_timing.hpp"

namespace matchbox_slam {

/// A configuration as it takes effect, for the node and for map_bag alike.
struct SlamSetup {
  RunOptions run;
  SlamNodeOptions node;
  CloudOptions cloud;
  ScanTimingOptions timing;
  EngineOptions engine;
  std::string matcher_name;  ///< lookup name
  std::shared_ptr<const ScanMatcher> matcher;
  HoughOptions
      hough;  ///< of what looks at Hough domains whatever the matcher: ~relocalise, --debug
};

/// Whose configuration it is: a program's has no option of the node alone.
enum class SetupOf { kNode, kProgram };

/// Reads everything there is to configure: the keys of RunOptions and SlamNodeOptions, the sections
/// of the engine, and one section a matcher, of which only the chosen one's takes effect, and
/// `hough`. What is not named keeps its default. Frames come without their leading slash. Throws
/// ConfigurationError for an unknown key, section or matcher and for a bad value.
[[nodiscard]] SlamSetup make_slam_setup(const Parameters& parameters, const MatcherCatalog& catalog,
                                        SetupOf whose = SetupOf::kNode);

/// The number in a configured `scan_time_offset`; none for 'auto'.
[[nodiscard]] std::optional<double> fixed_scan_time_offset(const RunOptions& options);

/// In what an image of the map is written.
[[nodiscard]] MapFormat map_format(const RunOptions& options);

/// Every option in effect that influences the trajectory and the map, by its full name.
[[nodiscard]] std::vector<OptionDescription> describe_setup(const SlamSetup& setup);

}  // namespace matchbox_slam
