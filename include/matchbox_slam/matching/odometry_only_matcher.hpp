#pragma once

#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Accepts every prediction as it is: the map that odometry alone makes, figure 6a of "The Scan
/// Matchers Research and Comparison: Monte-Carlo, Olson and Hough", and the baseline for every
/// other matcher. Has no options. Cost: none.
class OdometryOnlyMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& parameters) override;
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override;
};

}  // namespace matchbox_slam
