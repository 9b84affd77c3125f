#include "matchbox_slam/matching/refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

Eigen::Matrix3d prior_information(const Eigen::Matrix3d& covariance) {
  // A prior without variance has an information that is finite, yet beyond any scan's.
  constexpr double kLeastVariance = 1e-12;
  return (covariance + kLeastVariance * Eigen::Matrix3d::Identity()).inverse();
}

Eigen::Vector3d difference(const Pose2& pose, const Pose2& from) {
  return {pose.x - from.x, pose.y - from.y, wrap_angle(pose.theta - from.theta)};
}

/// Information of a metre of wall.
double information_scale(const RefinementOptions& options) {
  return 1.0 / (options.noise * options.noise * options.wall_per_measurement);
}

/// Directions of translation that the scan says little about, with the heading left free to follow.
std::vector<Eigen::Vector2d> weak_directions(const Eigen::Matrix3d& information, double weakest) {
  const double turn = information(2, 2);
  Eigen::Matrix2d translation = information.topLeftCorner<2, 2>();
  if (turn > 0.0) {
    const Eigen::Vector2d coupling = information.topRightCorner<2, 1>();
    translation -= coupling * coupling.transpose() / turn;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(translation);
  const double strongest = solver.eigenvalues()(1);
  std::vector<Eigen::Vector2d> weak;
  for (int i = 0; i < 2; ++i) {
    if (!(solver.eigenvalues()(i) > weakest * strongest)) {
      weak.emplace_back(solver.eigenvectors().col(i));
    }
  }
  return weak;
}

/// Takes out what the scan claims to know about translation along `direction`.
Eigen::Matrix3d without_direction(const Eigen::Matrix3d& information,
                                  const Eigen::Vector2d& direction) {
  Eigen::Matrix3d projector = Eigen::Matrix3d::Identity();
  projector.topLeftCorner<2, 2>() -= direction * direction.transpose();
  return projector * information * projector;
}

}  // namespace

RefinedPose refine(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                   const Pose2& start_map_from_base, const PosePrior& prior,
                   const RefinementOptions& options) {
  const Eigen::Matrix3d prior_part = prior_information(prior.covariance);
  const double scale = information_scale(options);
  RefinedPose refined;
  Pose2& pose = refined.map_from_base;
  pose = start_map_from_base;
  for (int i = 0; i < options.iterations; ++i) {
    // The kernel reaches its last width half-way, so that the last steps converge.
    const double progress = std::min(1.0, 2.0 * i / std::max(1, options.iterations - 1));
    const double kernel =
        options.first_kernel * std::pow(options.last_kernel / options.first_kernel, progress);
    const NormalEquations equations = Correspondences(points, field, pose).linearise(kernel);
    const Eigen::Matrix3d information = scale * equations.information + prior_part;
    const Eigen::Vector3d gradient =
        scale * equations.gradient + prior_part * difference(pose, prior.map_from_base);
    const Eigen::Vector3d step = -information.ldlt().solve(gradient);
    if (!step.allFinite()) {
      break;
    }
    pose = {pose.x + step.x(), pose.y + step.y(), wrap_angle(pose.theta + step.z())};
    if (progress >= 1.0 && step.head<2>().norm() < 1e-5 && std::abs(step.z()) < 1e-5) {
      break;
    }
  }
  const Correspondences last(points, field, pose);
  Eigen::Matrix3d information = last.linearise(options.last_kernel).information;
  refined.score = last.closeness(options.last_kernel, Eigen::Vector3d::Zero());
  refined.unconstrained_directions = weak_directions(information, options.weakest_direction);
  for (const Eigen::Vector2d& direction : refined.unconstrained_directions) {
    information = without_direction(information, direction);
    const Eigen::Vector2d off = prior.map_from_base.translation() - pose.translation();
    pose.x += direction.x() * direction.dot(off);
    pose.y += direction.y() * direction.dot(off);
  }
  refined.covariance = (scale * information + prior_part).inverse();
  return refined;
}

LocalPosterior::LocalPosterior(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                               const Pose2& map_from_base, const PosePrior& prior,
                               const RefinementOptions& options)
    : correspondences_(points, field, map_from_base),
      prior_information_(prior_information(prior.covariance)),
      off_prior_(difference(map_from_base, prior.map_from_base)),
      kernel_(options.last_kernel),
      scale_(information_scale(options) * correspondences_.total_weight()),
      closeness_(correspondences_.closeness(kernel_, Eigen::Vector3d::Zero())) {}

double LocalPosterior::cost(const Eigen::Vector3d& step) const {
  // The kernel's cost of a residual r is (k^2 / 2) r^2 / (k^2 + r^2) = (k^2 / 2) (1 - closeness).
  const double scan_part =
      0.5 * kernel_ * kernel_ * scale_ * (closeness_ - correspondences_.closeness(kernel_, step));
  const Eigen::Vector3d off = off_prior_ + step;
  return scan_part + 0.5 * (off.dot(prior_information_ * off) -
                            off_prior_.dot(prior_information_ * off_prior_));
}

}  // namespace matchbox_slam
