#include "matchbox_slam/matching/refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {
namespace {

/// Information of one measurement with a point's noise [1/m^2], estimated from the residuals.
double shown_information(const Correspondences& pairs, const RefinementOptions& options) {
  // The configured noise counts as much as this many residuals, since few points may agree by
  // chance. Half or double of it changes the mean NEES of pairs by 1 to 3 %.
  constexpr double kPriorResiduals = 10.0;
  // Least standard deviation, as a share of the configured noise: 2 mm by default, for the error of
  // the map, which even beams without noise have. With these the mean NEES of pairs in clutter is
  // 1.5; with half of it the same, with double 0.7. With 1 cm of noise it has no effect.
  constexpr double kMinDeviationShare = 0.2;
  // Widths of the last kernel to look through, since a narrow one hides large residuals. The mean
  // NEES of pairs, 3 if honest, is 3.8 and 3.5 (rooms, random) for 1, 3.0 and 2.6 for 2, and 2.7
  // and 1.9 for 4.
  constexpr double kKernel = 2.0;
  const double expected = options.noise * options.noise;
  const ResidualSum seen = pairs.residuals(kKernel * options.last_kernel);
  const double shown =
      (seen.squares + kPriorResiduals * expected) / (seen.measurements + kPriorResiduals);
  return 1.0 / std::max(shown, kMinDeviationShare * kMinDeviationShare * expected);
}

/// The motion (x, y, theta) along a weak direction that changes the residuals least: in a round
/// room going round its middle with a turn.
Eigen::Vector3d least_noticed(const Eigen::Matrix3d& information,
                              const Eigen::Vector2d& direction) {
  const double turn = information(2, 2);
  const double coupling = information.topRightCorner<2, 1>().dot(direction);
  return {direction.x(), direction.y(), turn > 0.0 ? -coupling / turn : 0.0};
}

/// Noise turns pieces of wall, too, until some face along a corridor: the more, the larger its
/// variance. That over the expected one is 0.36 in worlds with 1 cm of noise, where a corridor
/// shows no such piece, and 1.8 with 3 cm, where up to 0.01 of the information seems to come from
/// some: hence its square. Without noise cells turn them as well.
double noise_of_normals(const Correspondences& pairs, const RefinementOptions& options) {
  constexpr double kMinVarianceRatio = 0.36;
  const double variance = 1.0 / shown_information(pairs, options);
  const double share = std::max(kMinVarianceRatio, variance / (options.noise * options.noise));
  return share * share;
}

/// Directions of translation of which map and scan hardly confirm anything to each other, the
/// heading turned along, but for those that some surfaces clearly face: a few beams on the end of a
/// corridor tell more than what noise makes of all that are on its sides.
/// @param information  of the pairs under the last kernel.
std::vector<Eigen::Vector2d> weak_directions(const Correspondences& pairs,
                                             const Eigen::Matrix3d& information,
                                             const RefinementOptions& options) {
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
    const Eigen::Vector2d direction = solver.eigenvectors().col(i);
    const double least_facing =
        noise_of_normals(pairs, options) * options.weakest_facing * strongest;
    const Eigen::Vector3d motion = least_noticed(information, direction);
    if (!(pairs.confirmed_information(options.last_kernel, motion) >
          options.weakest_direction * strongest) &&
        !(pairs.facing_information(options.last_kernel, motion) > least_facing)) {
      weak.push_back(direction);
    }
  }
  return weak;
}

/// Takes the information along the weak directions out of the equations. Since a direction is an
/// eigenvector of the marginal information, its least noticed motion m has information along that
/// direction alone: m^T I m, in theory 0 or more along straight walls, by rounding also less.
NormalEquations without_weak_directions(NormalEquations scan,
                                        const std::vector<Eigen::Vector2d>& weak) {
  for (const Eigen::Vector2d& direction : weak) {
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
  pose = displaced(pose, step);
  constexpr double kMinStep = 1e-5;  // [m], [rad]: a hundredth of what a scan tells
  return step.head<2>().norm() >= kMinStep || std::abs(step.z()) >= kMinStep;
}

/// Whether the steps led away from prior and start alike: where neither holds a direction, the
/// prior's weight having faded far from it, they may lead anywhere.
bool has_run_off(const Pose2& pose, const Pose2& start, const PosePrior& prior) {
  constexpr double kMaxDeparture = 0.5;  // [m], more than the first kernel reaches
  const auto off = [&](const Pose2& some) {
    return (some.translation() - prior.map_from_base.translation()).norm();
  };
  return !(off(pose) <= off(start) + kMaxDeparture);
}

}  // namespace

Eigen::Matrix3d step_covariance(double step_xy, double step_theta) {
  return covariance_of(step_xy, step_theta) / 12.0;
}

RefinedPose refine(Correspondences& pairs, const Pose2& start_map_from_base, const PosePrior& prior,
                   const RefinementOptions& options) {
  const Eigen::Matrix3d information = prior_information(prior.covariance);
  const auto weighted_prior = [&](const Pose2& pose) -> Eigen::Matrix3d {
    const Eigen::Vector3d off = difference(pose, prior.map_from_base);
    return prior_weight_at(off.dot(information * off)) * information;
  };
  // Before the first step the prior has its full weight: where it leaves no room, a search that
  // came out beside it does not make it wrong.
  Eigen::Matrix3d prior_part = information;
  const double scale = 1.0 / (options.noise * options.noise);
  RefinedPose refined;
  Pose2& pose = refined.map_from_base;
  pose = start_map_from_base;
  for (int i = 0; i < options.iterations; ++i) {
    // The kernel reaches its last width half-way, so that the last steps converge.
    const double progress = std::min(1.0, 2.0 * i / std::max(1, options.iterations - 1));
    const double kernel =
        options.first_kernel * std::pow(options.last_kernel / options.first_kernel, progress);
    const NormalEquations scan = pairs.linearise(kernel);
    const bool goes_on = advance(step_to_optimum(scan, scale, pose, prior, prior_part), pose);
    pairs.move_to(pose);
    prior_part = weighted_prior(pose);
    if (!goes_on && progress >= 1.0) {
      break;
    }
  }
  NormalEquations scan = pairs.linearise(options.last_kernel);
  refined.unconstrained_directions = weak_directions(pairs, scan.information, options);
  if (!refined.unconstrained_directions.empty()) {
    // What the scan seemed to say along these directions was noise: the prior has its way there.
    for (int i = 0; i < options.iterations; ++i) {
      scan = pairs.linearise(options.last_kernel);
      scan = without_weak_directions(scan, weak_directions(pairs, scan.information, options));
      const bool goes_on = advance(step_to_optimum(scan, scale, pose, prior, prior_part), pose);
      pairs.move_to(pose);
      prior_part = weighted_prior(pose);
      if (!goes_on) {
        break;
      }
    }
  }
  if (has_run_off(pose, start_map_from_base, prior)) {
    pose = start_map_from_base;
    pairs.move_to(pose);
    scan = pairs.linearise(options.last_kernel);
    refined.unconstrained_directions = weak_directions(pairs, scan.information, options);
    scan = without_weak_directions(scan, refined.unconstrained_directions);
  }
  refined.covariance =
      (shown_information(pairs, options) * scan.information + weighted_prior(pose)).inverse();
  refined.score = pairs.closeness(options.last_kernel, Eigen::Vector3d::Zero());
  return refined;
}

LocalPosterior::LocalPosterior(const Correspondences& pairs, const Pose2& map_from_base,
                               const PosePrior& prior, const RefinementOptions& options)
    : correspondences_(pairs),
      prior_information_(prior_information(prior.covariance)),
      off_prior_(difference(map_from_base, prior.map_from_base)),
      kernel_(options.last_kernel),
      scan_information_(shown_information(correspondences_, options)),
      cost_here_(correspondences_.cost(kernel_, Eigen::Vector3d::Zero())) {}

double LocalPosterior::prior_cost(const Eigen::Vector3d& step) const {
  const auto penalty = [this](const Eigen::Vector3d& off) {
    return prior_penalty(off.dot(prior_information_ * off));
  };
  return 0.5 * (penalty(off_prior_ + step) - penalty(off_prior_));
}

double LocalPosterior::cost(const Eigen::Vector3d& step) const {
  return scan_information_ * (correspondences_.cost(kernel_, step) - cost_here_) + prior_cost(step);
}

void LocalPosterior::costs_of_both(const std::vector<Eigen::Vector3d>& steps,
                                   std::vector<std::array<double, 2>>& costs) const {
  correspondences_.costs_of_both(kernel_, steps, costs);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    costs[i] = {scan_information_ * costs[i][0] + prior_cost(steps[i]),
                scan_information_ * costs[i][1] + prior_cost(-steps[i])};
  }
}

}  // namespace matchbox_slam
