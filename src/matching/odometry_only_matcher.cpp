#include "matchbox_slam/matching/odometry_only_matcher.hpp"

namespace matchbox_slam {

void OdometryOnlyMatcher::configure(const Parameters& parameters) {
  reject_unknown_keys(parameters, "odometry_only", {});
}

MatchResult OdometryOnlyMatcher::match(const MatchProblem& problem) const {
  if (!is_valid_prior(problem)) {
    return rejected(problem, MatchStatus::kRejectedInvalidPrior);
  }
  if (problem.scan.points.empty()) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  MatchResult result = rejected(problem, MatchStatus::kAccepted);
  result.candidates = 1;
  return result;
}

}  // namespace matchbox_slam
