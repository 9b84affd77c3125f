#include "example_matcher/hill_climbing_matcher.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

PLUGINLIB_EXPORT_CLASS(example_matcher::HillClimbingMatcher, matchbox_slam::ScanMatcher)

namespace example_matcher {
namespace {

using namespace matchbox_slam;

/// How near to a wall the points fall, on average: 1 on it, 0 out of reach of all.
double fit(const MatchProblem& problem, const Pose2& map_from_base) {
  double sum = 0.0;
  for (const ScanPoint& point : problem.scan.points) {
    const Cell cell = problem.field.geometry().cell_at(map_from_base * point.position);
    sum += LikelihoodField::kFar - problem.field.distance(cell);
  }
  return sum / (LikelihoodField::kFar * static_cast<double>(problem.scan.points.size()));
}

/// Steps of one standard deviation along the axes of the prior's ellipsoid, as columns. They are
/// zero where the prior is certain, so that the search stays there.
Eigen::Matrix3d axes_of(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace

void HillClimbingMatcher::configure(const Parameters& parameters) {
  options_ = read_options<HillClimbingOptions>(parameters, "hill_climbing");
}

std::vector<OptionDescription> HillClimbingMatcher::options() const {
  return describe_options(options_);
}

MatchResult HillClimbingMatcher::match(const MatchProblem& problem) const {
  if (const std::optional<MatchResult> rejection = reject_unmatchable(problem)) {
    return *rejection;
  }

  // Search.
  const Eigen::Matrix3d axes = axes_of(problem.prior_covariance);
  Pose2 best = problem.predicted_map_from_base;
  double best_fit = fit(problem, best);
  std::size_t candidates = 1;
  double step = options_.first_step;
  for (int level = 0; level <= options_.halvings; ++level, step *= 0.5) {
    for (int direction = 0; direction < 6; ++direction) {
      const Eigen::Vector3d by = (direction % 2 == 0 ? step : -step) * axes.col(direction / 2);
      const Pose2 pose{best.x + by.x(), best.y + by.y(), wrap_angle(best.theta + by.z())};
      const double pose_fit = fit(problem, pose);
      ++candidates;
      if (pose_fit > best_fit) {
        best = pose;
        best_fit = pose_fit;
        direction = -1;  // look around anew
      }
    }
  }

  // Below the size of a cell, and how certain the answer is.
  const RefinedPose refined =
      refine(problem.scan.points, problem.field, best,
             {problem.predicted_map_from_base, problem.prior_covariance}, RefinementOptions{});
  MatchResult result = rejected(problem, MatchStatus::kRejectedLowScore);
  result.score = std::clamp(refined.score, 0.0, 1.0);
  result.candidates = candidates;
  if (refined.score >= options_.min_score) {
    result.status = MatchStatus::kAccepted;
    result.map_from_base = refined.map_from_base;
    result.refined_by = difference(refined.map_from_base, best);
    result.covariance = refined.covariance;
    result.unconstrained_directions = refined.unconstrained_directions;
  }
  return result;
}

}  // namespace example_matcher
