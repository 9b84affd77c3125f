#include "slam/match_validation.hpp"

#include <algorithm>

#include "matchbox_slam/matching/contradiction.hpp"
#include "matchbox_slam/matching/pose_prior.hpp"
#include "matchbox_slam/matching/refinement.hpp"
#include "matching/wide_search.hpp"
#include "slam/mutual_fit.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLeastScore = 0.4;
constexpr double kMostRival = 0.9;  // score of the best pose elsewhere, as a share

double score_at(const PointScan& scan, const Pose2& map_from_base, const LikelihoodField& field) {
  RefinementOptions none;
  none.iterations = 0;
  const PosePrior prior{map_from_base, Eigen::Matrix3d::Identity()};
  return refine(scan.points, field, map_from_base, prior, none).score;
}

}  // namespace

CheckedMatch search_and_check(const MatchProblem& problem, const OccupancyGrid& occupancy) {
  CheckedMatch checked{search_exactly(problem)};
  const PointScan& scan = problem.scan;
  const Pose2& pose = checked.match.map_from_base;
  const double on_other_sides = share_on_other_sides(scan, pose, problem.field, &occupancy);
  checked.violation =
      std::min(1.0, contradiction(scan, pose, problem.field) + 2.0 * on_other_sides);
  return checked;
}

bool is_convincing(const CheckedMatch& checked) {
  const MatchResult& match = checked.match;
  const bool is_searched = !match.proof || match.proof->gap() == 0.0;
  return match.accepted() && is_searched && match.score >= kLeastScore &&
         checked.violation <= kMostViolation && match.rival_share <= kMostRival;
}

bool is_out_of_place(const PointScan& scan, const Pose2& map_from_base, const SlamMap& map) {
  constexpr double kMapped = 0.7;  // share of the scan, from which on it should fit
  return contradiction(scan, map_from_base, map.field) > kMostViolation ||
         (score_at(scan, map_from_base, map.field) < kLeastScore &&
          ground_shares(scan, map_from_base, map).mapped > kMapped);
}

}  // namespace matchbox_slam
