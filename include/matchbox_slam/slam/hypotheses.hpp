#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

struct HypothesisOptions {
  bool enabled = true;
  double decisive = 4.6;
  double unexpected = 7.0;
  double carried = 9.2;
  double search_xy = 0.5;
  double search_theta = 1.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.enabled, "enabled", any(), "",
           "Whether the robot may be elsewhere than the matcher has it; false: every match is "
           "believed.");
    option(self.decisive, "decisive", between(0.5, 50.0), "",
           "Log odds from which on one hypothesis takes the place of another; 4.6 is 99 to 1.");
    option(self.unexpected, "unexpected", between(0.0, 50.0), "",
           "Log odds, before any scan, against a pose that the motion does not lead to.");
    option(self.carried, "carried", between(0.0, 100.0), "",
           "Log odds, before any scan, against the robot being somewhere unknown, as when it was "
           "carried there.");
    option(self.search_xy, "search_xy", between(0.01, 2.0), "m",
           "Where a scan fits badly other poses are searched: standard deviation of the position "
           "that this adds to the prior's.");
    option(self.search_theta, "search_theta", between(0.01, 3.2), "rad",
           "Likewise of the heading.");
  }
};

/// Where the robot may be.
struct PoseHypothesis {
  Pose2 map_from_base;    ///< at the newest scan
  double log_odds = 0.0;  ///< against the leading one
  /// Where it has the key scans that were inserted since the fork; none for those from before it
  /// came up, which it shares with the leading one.
  std::vector<std::optional<Pose2>> key_scans = {};
};

/// There is more than one hypothesis since then.
struct HypothesesFork {
  std::size_t key_scans = 0;  ///< that the map had
  std::size_t inserted = 0;   ///< since
  double undecided = 0.0;     ///< [m] travelled since a scan told hypotheses apart
  double searched = 0.0;      ///< [m] and [rad] travelled since other poses were searched
};

/// How far a scan saw in each direction [m]: the nearest hit of each sector around the base, from
/// -pi on; 0 where there is none.
using ScanProfile = std::array<float, 72>;

/// All that is known of them: a value, to be copied and saved. See PoseHypotheses.
struct HypothesesState {
  std::optional<HypothesesFork> fork;
  std::vector<PoseHypothesis> others;  ///< than the leading one
  /// Log odds of somewhere unknown; as low as the options say where nothing speaks for it.
  double elsewhere = -std::numeric_limits<double>::infinity();
  ScanProfile profile = {};  ///< of the newest scan
};

}  // namespace matchbox_slam
