#include "slam/prior_odds.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/chi_square.hpp"
#include "matchbox_slam/matching/pose_prior.hpp"

namespace matchbox_slam {
namespace {

double squared_distance(const MatchProblem& problem, const Pose2& pose,
                        const Eigen::Matrix3d& information) {
  const Eigen::Vector3d off = difference(pose, problem.predicted_map_from_base);
  return off.dot(information * off);
}

}  // namespace

double prior_log_odds(const MatchProblem& problem, const Pose2& pose) {
  const Eigen::Matrix3d learned = prior_information(problem.prior_covariance);
  const Eigen::Matrix3d searched = prior_information(problem.searched_covariance());
  const double expected = -0.5 * squared_distance(problem, pose, learned);
  const double density = 0.5 * std::log(searched.determinant() / learned.determinant());
  const double unexpected =
      -kPriorAgainstJump + density - 0.5 * prior_penalty(squared_distance(problem, pose, searched));
  return std::max(expected, unexpected);
}

bool is_unexpected(const MatchProblem& problem, const Pose2& pose) {
  return squared_distance(problem, pose, prior_information(problem.prior_covariance)) >
         kMostChiSquare;
}

}  // namespace matchbox_slam
