#pragma once

#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/motion/motion_prior.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/hypotheses.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "matchbox_slam/slam/place_search.hpp"

namespace matchbox_slam {

struct SlamOptions {
  double insert_distance = 0.3;
  double insert_angle = 0.2;
  double insert_overlap = 0.0;
  int recent_scans = 30;
  int min_points = 10;
  bool update_map = true;
  bool loop_closing = true;
  int enough_views = 9;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.insert_distance, "insert_distance", between(0.0, 100.0), "m",
           "A scan is inserted into the map after this much motion since the last one inserted; 0: "
           "every scan.");
    option(
        self.insert_angle, "insert_angle", between(0.0, 3.2), "rad",
        "A scan is inserted into the map after this much turning since the last one inserted; 0: "
        "every scan.");
    option(self.insert_overlap, "insert_overlap", between(0.0, 1.0), "",
           "A scan that was matched is inserted also when less than this share of it has the map "
           "near; 0: by motion alone.");
    option(self.recent_scans, "recent_scans", between(1, 10000), "",
           "The newest inserted scans, so many, are what matchers of scan to scan look at.");
    option(self.min_points, "min_points", between(1, 100000), "",
           "Scans with fewer hits are not matched; the prediction stands.");
    option(self.update_map, "update_map", any(), "",
           "Whether scans are inserted; if not, the map that is there, with what was seen of late, "
           "only tells where the robot is.");
    option(self.loop_closing, "loop_closing", any(), "",
           "Whether places that are seen again after a long way move the map, so that it fits.");
    option(self.enough_views, "enough_views", between(0, 1000), "",
           "A key scan makes room when so many newer ones were taken beside it that see the same: "
           "three are one time driven past. What it said of others the graph keeps. 0: all are "
           "kept. Needs slam/loop_closing.");
  }
};

/// The section `scan`. Throws ConfigurationError, also where its options do not fit together.
[[nodiscard]] ProjectionOptions read_projection_options(const Parameters& parameters);

/// All options of the engine, a section each: `slam/`, `scan/`, `map/`, `field/`, `motion/`,
/// `hypotheses/`, `recovery/`, `loops/`.
struct EngineOptions {
  SlamOptions slam;
  ProjectionOptions scan;
  MapOptions map;
  LikelihoodFieldOptions field;
  MotionPriorOptions motion;
  HypothesisOptions hypotheses;
  RecoveryOptions recovery;
  LoopOptions loops;
};

/// Reads the engine's sections from `parameters`; other keys are left to their owners.
/// Throws ConfigurationError for unknown keys within the sections and for bad values.
[[nodiscard]] EngineOptions read_engine_options(const Parameters& parameters);

/// All rows, with names that carry their section.
[[nodiscard]] std::vector<OptionDescription> describe_engine_options(const EngineOptions& options);

}  // namespace matchbox_slam
