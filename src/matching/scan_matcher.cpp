#include "matchbox_slam/matching/scan_matcher.hpp"

#include <Eigen/Eigenvalues>

namespace matchbox_slam {

const char* to_string(MatchStatus status) {
  switch (status) {
    case MatchStatus::kAccepted:
      return "accepted";
    case MatchStatus::kRejectedNoReference:
      return "rejected_no_reference";
    case MatchStatus::kRejectedTooFewPoints:
      return "rejected_too_few_points";
    case MatchStatus::kRejectedLowScore:
      return "rejected_low_score";
    case MatchStatus::kRejectedUnexpected:
      return "rejected_unexpected";
    case MatchStatus::kRejectedInvalidPrior:
      return "rejected_invalid_prior";
  }
  return "unknown";
}

bool is_covariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) {
    return false;
  }
  const double scale = covariance.cwiseAbs().maxCoeff();
  const double tolerance = 1e-9 * scale;
  if (!(covariance - covariance.transpose()).isZero(tolerance)) {
    return false;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= -tolerance;
}

bool is_valid_prior(const MatchProblem& problem) {
  return problem.predicted_map_from_base.is_finite() && is_covariance(problem.prior_covariance) &&
         is_covariance(problem.searched_covariance());
}

MatchResult rejected(const MatchProblem& problem, MatchStatus why) {
  MatchResult result;
  result.map_from_base = problem.predicted_map_from_base;
  result.covariance = problem.prior_covariance;
  result.status = why;
  return result;
}

namespace {

std::optional<MatchResult> reject_without(bool reference, const MatchProblem& problem) {
  if (!is_valid_prior(problem)) {
    return rejected(problem, MatchStatus::kRejectedInvalidPrior);
  }
  if (problem.scan.points.empty()) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  if (!reference) {
    return rejected(problem, MatchStatus::kRejectedNoReference);
  }
  return std::nullopt;
}

}  // namespace

std::optional<MatchResult> reject_unmatchable(const MatchProblem& problem) {
  return reject_without(!problem.field.empty(), problem);
}

std::optional<MatchResult> reject_unmatchable_to_scans(const MatchProblem& problem) {
  return reject_without(!problem.recent_scans.empty(), problem);
}

}  // namespace matchbox_slam
