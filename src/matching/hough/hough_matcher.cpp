#include "matchbox_slam/matching/hough/hough_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "matching/hough/hough_search.hpp"

namespace matchbox_slam {
namespace {

/// Distance of two poses [m] in which a turn of 1 rad, after which a laser of 180 degrees sees two
/// thirds of the same, counts as a step of 1 m.
double apart(const Pose2& a, const Pose2& b) {
  constexpr double kMetresPerRadian = 1.0;
  return (a.translation() - b.translation()).norm() +
         kMetresPerRadian * std::abs(wrap_angle(a.theta - b.theta));
}

/// Key scans by their distance from a pose, nearest first; of equals the newest first.
PlacedScans nearest(const PlacedScans& key_scans, const Pose2& pose) {
  PlacedScans sorted(key_scans.rbegin(), key_scans.rend());
  std::stable_sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) {
    return apart(a.map_from_base, pose) < apart(b.map_from_base, pose);
  });
  return sorted;
}

/// Refines a pose against the map, or while there is none, against the nearest key scan.
RefinedPose refined(const MatchProblem& problem, const Pose2& map_from_base, const PosePrior& prior,
                    const RefinementOptions& options) {
  if (!problem.field.empty()) {
    return refine(problem.scan.points, problem.field, map_from_base, prior, options);
  }
  const PlacedScan key = nearest(problem.recent_scans, map_from_base).front();
  const std::shared_ptr<const LikelihoodField> field = key.scan->field();
  return refine(problem.scan.points, PlacedFields{{field.get(), key.map_from_base}}, map_from_base,
                prior, options);
}

}  // namespace

void HoughMatcher::configure(const Parameters& parameters) {
  options_ = read_options<HoughOptions>(parameters, "hough");
}

std::vector<OptionDescription> HoughMatcher::options() const { return describe_options(options_); }

MatchResult HoughMatcher::match(const MatchProblem& problem) const {
  if (const std::optional<MatchResult> rejection = reject_unmatchable_to_scans(problem)) {
    return *rejection;
  }
  const PosePrior prior{problem.predicted_map_from_base, problem.prior_covariance};
  const PosePrior searched{problem.predicted_map_from_base, problem.searched_covariance()};
  const SearchedScan scan(problem.scan, options_.alignment.point_spacing);
  if (scan.points.empty()) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  const PlacedScans near = nearest(problem.recent_scans, prior.map_from_base);
  MatchResult result = rejected(problem, MatchStatus::kRejectedLowScore);
  const double prior_weight = weight_beside(problem.scan, options_.prior_weight);
  std::vector<RankedPose> poses;
  for (std::size_t i = 0;
       i < std::min(near.size(), static_cast<std::size_t>(options_.searched_key_scans)); ++i) {
    const std::vector<RankedPose> more =
        search_key_scan(scan, near[i], searched, prior_weight, options_.alignment).poses;
    poses.insert(poses.end(), more.begin(), more.end());
    result.candidates += more.size();
    sort_and_thin(poses);
    if (!poses.empty() && poses.front().score >= options_.enough_score) {
      break;
    }
  }
  if (poses.empty()) {
    return result;
  }
  const RefinedPose answer =
      refined(problem, poses.front().map_from_base, prior, options_.refinement);
  if (!std::isfinite(answer.score) || !answer.map_from_base.is_finite() ||
      !answer.covariance.allFinite()) {
    return result;
  }
  result.score = std::clamp(answer.score, 0.0, 1.0);
  if (poses.size() > 1 && poses[0].score > 0.0) {
    result.rival_share = std::clamp(poses[1].score / poses[0].score, 0.0, 1.0);
  }
  if (answer.score < options_.min_score) {
    return result;
  }
  result.status = MatchStatus::kAccepted;
  result.map_from_base = answer.map_from_base;
  result.refined_by = difference(answer.map_from_base, poses.front().map_from_base);
  result.covariance = answer.covariance;
  if (options_.refinement.iterations == 0) {
    const HoughAlignmentOptions& alignment = options_.alignment;
    result.covariance += step_covariance(alignment.rho_cell, kPi / alignment.angles);
  }
  result.unconstrained_directions = answer.unconstrained_directions;
  return result;
}

}  // namespace matchbox_slam
