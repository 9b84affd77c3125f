#pragma once

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Log odds of a scan for one pose and against another, by the points that both have on known
/// ground, and by those that lie across the way between both, as all without normal do: that one of
/// them has more of the scan along walls that nobody has seen, or on their other side, says
/// nothing.
/// @param map  with its field rendered.
[[nodiscard]] double evidence_between(const PointScan& scan, const Pose2& one, const Pose2& other,
                                      const SlamMap& map);

/// Matches so that unknown ground draws nobody. A search finds the pose that lays most of a scan on
/// walls: at the border of what is mapped that is one further back than the robot is, since what it
/// sees anew lies on none. Between two poses a point tells only where both have it on known ground.
/// So where a match has points on known ground that lie on none by odometry, along the way between
/// both or on the other side of a wall, the scan is matched once more without them, and the first
/// answer stands only where the others speak for it, too. What shows the other side of a wall by
/// odometry, too, is no reason for that where both agree along the way that the scan holds least.
class CommonGroundMatch {
 public:
  /// @param map  the one that the problem's field is of.
  [[nodiscard]] MatchResult match(const ScanMatcher& matcher, const MatchProblem& problem,
                                  const SlamMap& map);

 private:
  PointScan common_;
};

}  // namespace matchbox_slam
