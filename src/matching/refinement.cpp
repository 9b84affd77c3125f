#include "matchbox_slam/matching/refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

Eigen::Vector3d difference(const Pose2& pose, const Pose2& from) {
  return {pose.x - from.x, pose.y - from.y, wrap_angle(pose.theta - from.theta)};
}

/// Information of a measurement with a point's noise, as the residuals show it.
double shown_information(const Correspondences& pairs, const RefinementOptions& options) {
  // Few points may agree by chance: so many that agree with the option are thought with them.
  constexpr double kBelieved = 10.0;
  // Nobody is better than this share of the option, as a standard deviation: also where the beams
  // have no noise, the map has an error.
  constexpr double kLeast = 0.2;
  // Seen through the last kernel, residuals would seem smaller than they are.
  constexpr double kKernel = 2.0;
  const double expected = options.noise * options.noise;
  const ResidualSum seen = pairs.residuals(kKernel * options.last_kernel);
  const double shown = (seen.squares + kBelieved * expected) / (seen.measurements + kBelieved);
  return 1.0 / std::max(shown, kLeast * kLeast * expected);
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

/// The motion of the base along a weak direction that the scan notices least: the heading follows,
/// as in a round room, where nobody can tell going round from turning.
Eigen::Vector3d least_noticed(const Eigen::Matrix3d& information,
                              const Eigen::Vector2d& direction) {
  const double turn = information(2, 2);
  const double coupling = information.topRightCorner<2, 1>().dot(direction);
  return {direction.x(), direction.y(), turn > 0.0 ? -coupling / turn : 0.0};
}

/// Takes out what the scan claims to know about motions along its weak directions. A direction
/// being an eigenvector of the translation's information with the heading free to follow, its
/// motion is noticed in that direction alone; there a map of straight walls says nothing, but for
/// rounding, which may make it less than nothing.
NormalEquations without_weak_directions(NormalEquations scan, double weakest) {
  for (const Eigen::Vector2d& direction : weak_directions(scan.information, weakest)) {
    const Eigen::Vector3d motion = least_noticed(scan.information, direction);
    const Eigen::Vector3d noticed(direction.x(), direction.y(), 0.0);
    scan.gradient -= noticed * motion.dot(scan.gradient);
    scan.information -= noticed * noticed.transpose() * motion.dot(scan.information * motion);
  }
  return scan;
}

/// One Gauss-Newton step on scan and prior together.
Eigen::Vector3d step_to_optimum(const NormalEquations& scan, double scale, const Pose2& pose,
                                const PosePrior& prior, const Eigen::Matrix3d& prior_part) {
  const Eigen::Matrix3d information = scale * scan.information + prior_part;
  const Eigen::Vector3d gradient =
      scale * scan.gradient + prior_part * difference(pose, prior.map_from_base);
  return -information.ldlt().solve(gradient);
}

/// Makes the step. False when there is nothing more to gain from another.
bool advance(const Eigen::Vector3d& step, Pose2& pose) {
  if (!step.allFinite()) {
    return false;
  }
  pose = {pose.x + step.x(), pose.y + step.y(), wrap_angle(pose.theta + step.z())};
  return step.head<2>().norm() >= 1e-5 || std::abs(step.z()) >= 1e-5;
}

}  // namespace

Eigen::Matrix3d prior_information(const Eigen::Matrix3d& covariance) {
  // Beyond what any scan knows, and less than anybody can be ignorant of.
  constexpr double kLeastVariance = 1e-12;
  constexpr double kMostVariance = 1e12;
  // More than this between the largest and the smallest, and rounding would make it indefinite.
  constexpr double kLeastShare = 1e-9;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const double largest = std::min(kMostVariance, solver.eigenvalues().maxCoeff());
  const double least = std::max(kLeastVariance, kLeastShare * largest);
  const Eigen::Vector3d variances = solver.eigenvalues().cwiseMax(least).cwiseMin(kMostVariance);
  return solver.eigenvectors() * variances.cwiseInverse().asDiagonal() *
         solver.eigenvectors().transpose();
}

RefinedPose refine(const std::vector<ScanPoint>& points, const LikelihoodFields& fields,
                   const Pose2& start_map_from_base, const PosePrior& prior,
                   const RefinementOptions& options) {
  const Eigen::Matrix3d prior_part = prior_information(prior.covariance);
  const double scale = 1.0 / (options.noise * options.noise);
  RefinedPose refined;
  Pose2& pose = refined.map_from_base;
  pose = start_map_from_base;
  Correspondences pairs(points, fields, pose);
  for (int i = 0; i < options.iterations; ++i) {
    // The kernel reaches its last width half-way, so that the last steps converge.
    const double progress = std::min(1.0, 2.0 * i / std::max(1, options.iterations - 1));
    const double kernel =
        options.first_kernel * std::pow(options.last_kernel / options.first_kernel, progress);
    const NormalEquations scan = pairs.linearise(kernel);
    const bool goes_on = advance(step_to_optimum(scan, scale, pose, prior, prior_part), pose);
    pairs.move_to(pose);
    if (!goes_on && progress >= 1.0) {
      break;
    }
  }
  NormalEquations scan = pairs.linearise(options.last_kernel);
  refined.unconstrained_directions = weak_directions(scan.information, options.weakest_direction);
  if (!refined.unconstrained_directions.empty()) {
    // What the scan seemed to say along these directions was noise: the prior has its way there.
    for (int i = 0; i < options.iterations; ++i) {
      scan =
          without_weak_directions(pairs.linearise(options.last_kernel), options.weakest_direction);
      const bool goes_on = advance(step_to_optimum(scan, scale, pose, prior, prior_part), pose);
      pairs.move_to(pose);
      if (!goes_on) {
        break;
      }
    }
  }
  refined.covariance =
      (shown_information(pairs, options) * scan.information + prior_part).inverse();
  refined.score = pairs.closeness(options.last_kernel, Eigen::Vector3d::Zero());
  return refined;
}

LocalPosterior::LocalPosterior(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                               const Pose2& map_from_base, const PosePrior& prior,
                               const RefinementOptions& options)
    : correspondences_(points, field, map_from_base),
      prior_information_(prior_information(prior.covariance)),
      off_prior_(difference(map_from_base, prior.map_from_base)),
      kernel_(options.last_kernel),
      scan_information_(shown_information(correspondences_, options)),
      cost_here_(correspondences_.cost(kernel_, Eigen::Vector3d::Zero())) {}

double LocalPosterior::cost(const Eigen::Vector3d& step) const {
  const double scan_part = scan_information_ * (correspondences_.cost(kernel_, step) - cost_here_);
  const Eigen::Vector3d off = off_prior_ + step;
  return scan_part + 0.5 * (off.dot(prior_information_ * off) -
                            off_prior_.dot(prior_information_ * off_prior_));
}

}  // namespace matchbox_slam
