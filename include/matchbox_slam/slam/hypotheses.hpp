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

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.enabled, "enabled", any(), "",
           "Whether the robot may be elsewhere than the matcher has it; false: every match is "
           "believed.");
    option(self.decisive, "decisive", between(0.5, 50.0), "",
           "Log odds from which on one hypothesis takes the place of another; 4.6 is 99 to 1.");
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
  /// Log odds of somewhere unknown: -9.2 at least, but where no scan was weighed since it was
  /// decided.
  double elsewhere = -std::numeric_limits<double>::infinity();
  ScanProfile profile = {};  ///< of the newest scan
};

}  // namespace matchbox_slam
