#include "matchbox_slam/slam/tracking.hpp"

namespace matchbox_slam {

Tracking::Held Tracking::follow(const WeighedMatch& match, double stamp, double seconds, double way,
                                const Pose2& map_from_base, const EngineOptions& options) {
  // Weight of the newest score among those of late: ten scans count most. A guess; half or double
  // changes no byte of six drives with faults and two logs
  // (benchmark/reports/current/CONSTANTS.md).
  constexpr double kNewest = 0.1;
  // What is found in doubt may be wrong, and fits less than it would elsewhere; what the map
  // contradicts was not scored against it.
  if (match.match.accepted() && !doubt_.doubts && !match.jumped && !match.overruled) {
    usual_score_ += (usual_score_ > 0.0 ? kNewest : 1.0) * (match.match.score - usual_score_);
  }
  const bool is_in_map =
      match.match.accepted() && match.match.contradiction <= options.doubt.contradiction;
  contradicted_way_ = is_in_map ? 0.0 : contradicted_way_ + way;
  const bool was_provisional = doubt_.is_provisional;
  doubt_.pass(seconds);
  doubt_.follow(match, stamp, way, map_from_base, usual_score_, options.doubt, options.tracking);
  // What was held before a jump lies where the robot is not.
  if (doubt_.is_provisional && was_provisional && !match.jumped) {
    return {};
  }
  std::vector<WaitingScan> held = std::exchange(held_, {});
  if (doubt_.doubts) {
    return {{}, !held.empty()};
  }
  return {std::move(held), false};
}

void Tracking::believe() {
  doubt_ = {};
  contradicted_way_ = 0.0;
  held_.clear();
}

}  // namespace matchbox_slam
