#include "slam/match_validation.hpp"

#include <algorithm>

#include "matchbox_slam/matching/free_space_violation.hpp"
#include "matching/wide_search.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLeastScore = 0.4;
constexpr double kMostRival = 0.9;  // score of the best pose elsewhere, as a share

}  // namespace

CheckedMatch search_and_check(const MatchProblem& problem, const OccupancyGrid& occupancy) {
  CheckedMatch checked{search_exactly(problem)};
  const PointScan& scan = problem.scan;
  const Pose2& pose = checked.match.map_from_base;
  const double on_other_sides = share_on_other_sides(scan, pose, problem.field, &occupancy);
  checked.violation =
      std::min(1.0, free_space_violation(scan, pose, problem.field) + 2.0 * on_other_sides);
  return checked;
}

bool is_convincing(const CheckedMatch& checked) {
  const MatchResult& match = checked.match;
  const bool is_searched = !match.proof || match.proof->gap() == 0.0;
  return match.accepted() && is_searched && match.score >= kLeastScore &&
         checked.violation <= kMostViolation && match.rival_share <= kMostRival;
}

}  // namespace matchbox_slam
