#pragma once

#include <Eigen/Core>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// The pose predicted from motion alone, and how well it is known.
struct PosePrior {
  Pose2 map_from_base;
  Eigen::Matrix3d covariance;  ///< over (x, y, theta) in the map frame
};

/// Inverse of a prior's covariance, with the eigenvalues limited so that it is finite and positive
/// definite for any covariance, that of a perfectly known pose included.
[[nodiscard]] Eigen::Matrix3d prior_information(const Eigen::Matrix3d& covariance);

/// Squared distance from a prior, in its standard deviations, up to which it is taken at its word:
/// a right one is closer in 19 of 20 cases (chi squared of three degrees of freedom). With half of
/// it, the mean relation of monte_carlo in intel is 0.0677 m instead of 0.0675, and belgioioso's
/// error 0.202 m instead of 0.193; double changes nothing.
constexpr double kPriorKernelThreshold = 7.8;

/// What a prior says against a pose, twice the negative logarithm of a probability: up to
/// kPriorKernelThreshold the squared distance itself, as of a Gaussian; beyond it rises ever less,
/// to three times kPriorKernelThreshold at most.
///
/// A prior can be wrong: wheels slip, odometry hangs. A Gaussian then rules out the truth, however
/// well it fits: five standard deviations away it costs more than a perfect fit is worth. With this
/// tail a clearly better fit wins wherever the search looks. It is the kernel of dynamic covariance
/// scaling (Agarwal et al., "Robust Map Optimization Using Dynamic Covariance Scaling", ICRA 2013;
/// as a kernel: MacTavish and Barfoot, "At All Costs", CRV 2015): beyond the first part that of
/// Geman and McClure, which alone would also weaken a prior that is right. Never falls with the
/// distance, so that the bounds of a search stay valid.
/// @param square  squared Mahalanobis distance, 0...infinity.
[[nodiscard]] inline double prior_penalty(double square) {
  return square <= kPriorKernelThreshold
             ? square
             : 3.0 * kPriorKernelThreshold - 4.0 * kPriorKernelThreshold * kPriorKernelThreshold /
                                                 (kPriorKernelThreshold + square);
}

/// The share of its information that a prior keeps at a pose: the slope of prior_penalty, the
/// weight of iteratively reweighted least squares.
[[nodiscard]] inline double prior_weight_at(double square) {
  const double root = 2.0 * kPriorKernelThreshold / (kPriorKernelThreshold + square);
  return square <= kPriorKernelThreshold ? 1.0 : root * root;
}

/// What a standard deviation of the prior costs beside the mean likelihood of a scan. The mean says
/// as much of six beams as of a thousand; of little wall it tells less than the prior.
/// @param weight  that of a scan of much wall.
[[nodiscard]] double weight_beside(const PointScan& scan, double weight);

}  // namespace matchbox_slam
