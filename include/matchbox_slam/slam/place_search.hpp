#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

struct RecoveryOptions {
  double interval = 0.1;
  int places = 12;
  double sure = 13.8;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.interval, "interval", between(0.0, 60.0), "s",
           "While the robot is lost, key scans of what it sees are searched in the map as often as "
           "this at most.");
    option(self.places, "places", between(1, 1000), "",
           "Places that such a key scan is compared with, of those that look most alike, about a "
           "millisecond each.");
    option(self.sure, "sure", between(1.0, 100.0), "",
           "Log odds from which on a lost robot counts as found at a place; 13.8 is a million to "
           "one. Near where odometry says it is hypotheses/decisive less.");
  }
};

/// Where a lost robot may be.
struct PlaceHypothesis {
  std::size_t component = 0;  ///< of the map
  Pose2 component_from_active;
  double log_odds = 0.0;  ///< against somewhere unknown
  /// Log odds, since it was found, of what explained each key scan best against it.
  double behind = 0.0;
};

/// Of a key scan that a lost robot has taken, how well it is explained anywhere.
struct ExplainedScan {
  std::uint64_t key_scan = 0;  ///< of the component that the robot makes meanwhile
  std::size_t component = 0;   ///< of the map, where it is explained best
  Pose2 component_from_base;
  double best = 0.0;       ///< log odds, as of ScanEvidence
  double elsewhere = 0.0;  ///< the same of the best place but that one
};

/// What is known of where a lost robot may be: a value, to be copied and saved. "Active" is the
/// frame of the component that the robot makes meanwhile.
struct PlaceSearch {
  double stamp = 0.0;  ///< [s] of the scan that was searched last
  /// Key scans of the map around which places are known; before all are, nothing is searched.
  std::uint64_t indexed = 0;
  int sampled = 0;  ///< key scans of the map that were looked for elsewhere in it
  int alike = 0;    ///< of these, such as may have been taken there
  std::vector<ExplainedScan> explained;
  std::vector<PlaceHypothesis> hypotheses;
};

}  // namespace matchbox_slam
