#include "matchbox_slam/motion/odometry_noise_scale.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

/// Where a match says less than this about a direction, its answer is the prediction's own.
constexpr double kMostVarianceLeft = 0.5;  // of the prior's variance

/// @param squared  error over its standard deviation, squared; 1 where the share is right.
double follow(double share, double squared, double weight, double min_scale) {
  constexpr double kMaxChiSquare = 16.0;  // one step of wheels that slip is not their usual error
  const double factor = 1.0 + weight * (std::min(squared, kMaxChiSquare) - 1.0);
  return std::clamp(share * std::sqrt(factor), min_scale, 1.0);
}

}  // namespace

MotionEstimate scaled_by(const OdometryNoiseScale& scale, MotionEstimate estimate) {
  const Eigen::Vector3d shares(scale.translation, scale.translation, scale.rotation);
  estimate.covariance = shares.asDiagonal() * estimate.covariance * shares.asDiagonal();
  estimate.floor = shares.asDiagonal() * estimate.floor * shares.asDiagonal();
  return estimate;
}

OdometryNoiseScale updated_noise_scale(const OdometryNoiseScale& scale, const Pose2& moved,
                                       const Pose2& predicted, const Eigen::Matrix3d& prior,
                                       const Pose2& matched, const Eigen::Matrix3d& posterior,
                                       double min_scale) {
  constexpr double kNoiseMemory = 2.0;  // [m] of way; worse with more
  const Eigen::LLT<Eigen::Matrix2d> factor(prior.topLeftCorner<2, 2>());
  if (factor.info() != Eigen::Success || !(prior(2, 2) > 0.0)) {
    return scale;
  }
  const double weight = 1.0 - std::exp(-way_with_turn(moved) / kNoiseMemory);
  OdometryNoiseScale result = scale;
  if (posterior(2, 2) < kMostVarianceLeft * prior(2, 2)) {
    const double turned = wrap_angle(matched.theta - predicted.theta);
    result.rotation = follow(result.rotation, turned * turned / (prior(2, 2) - posterior(2, 2)),
                             weight, min_scale);
  }
  const Eigen::Matrix2d whitened = Eigen::Matrix2d(factor.matrixL()).inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
      whitened * posterior.topLeftCorner<2, 2>() * whitened.transpose());
  const Eigen::Vector2d off = axes.eigenvectors().transpose() * whitened *
                              (matched.translation() - predicted.translation());
  for (int i = 0; i < 2; ++i) {
    const double left = std::max(0.0, axes.eigenvalues()[i]);
    if (left < kMostVarianceLeft) {
      result.translation =
          follow(result.translation, off[i] * off[i] / (1.0 - left), weight, min_scale);
    }
  }
  return result;
}

}  // namespace matchbox_slam
