#include "matching/wide_search.hpp"

#include <utility>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace matchbox_slam {
namespace {

/// Its steps are wider than the matcher's: the refinement's basin is wider still.
OlsonOptions search_options() {
  OlsonOptions options;
  options.step_xy = 0.05;       // [m]
  options.step_theta = 0.02;    // [rad]
  options.point_spacing = 0.1;  // [m]
  // What scores less is refined to something convincing by chance alone; with this limit a search
  // where nothing fits takes a third of the time.
  options.search_floor = 0.15;
  options.most_look_ups = 2500000;  // some 10 ms
  options.window_sigmas = 2.0;
  options.max_window_xy = 1.5;  // [m]
  return options;
}

}  // namespace

MatchResult search_exactly(const MatchProblem& problem) {
  return OlsonMatcher(search_options()).match(problem);
}

std::vector<MatchResult> search_widely(const MatchProblem& problem) {
  // Standard deviations that are added to the prior's.
  constexpr double kWideXy = 0.5;       // [m]
  constexpr double kNarrowTheta = 0.2;  // [rad], its window twice that, below a quarter of a turn
  constexpr double kWideTheta = 1.0;    // [rad]
  std::vector<MatchResult> found;
  for (const double sigma_theta : {kNarrowTheta, kWideTheta}) {
    MatchProblem wide = problem;
    wide.prior_covariance += covariance_of(kWideXy, sigma_theta);
    MatchResult match = search_exactly(wide);
    if (match.accepted()) {
      found.push_back(std::move(match));
    }
  }
  return found;
}

}  // namespace matchbox_slam
