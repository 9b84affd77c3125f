#pragma once

#include <cstdint>
#include <optional>

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/doubt.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/motion_tracker.hpp"

namespace matchbox_slam {

/// A scan to be matched, whatever is predicted of it.
struct ScanToMatch {
  const PointScan& scan;
  const SlamMap& map;
  const PlacedScans& recent;
  std::uint64_t seed;
  Expectation expected;
  /// Where loops may move it, and `recent` is what was seen last.
  bool may_map_be_wrong = false;
};

/// Matches a scan and weighs the answer. Where there is no map yet, or the scan has too few points,
/// the matcher is not asked. Where the map may be wrong and contradicts the answer, and the newest
/// key scans do not, what matches these is believed, for a metre. Where odometry tells of a step
/// that cannot be, or leads into doubt or to a far turn, the robot may have gone on as it did: then
/// `predicted` becomes that.
/// @param steady  the prediction by the last motion alone, if it is to be asked.
[[nodiscard]] WeighedMatch match_likeliest(const ScanMatcher& matcher, const ScanToMatch& scan,
                                           const std::optional<SteadyPrediction>& steady,
                                           MotionPrediction& predicted,
                                           const EngineOptions& options);

}  // namespace matchbox_slam
