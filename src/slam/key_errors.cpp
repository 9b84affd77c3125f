#include "matchbox_slam/slam/key_errors.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace matchbox_slam {
namespace {

/// Takes the error of a pose, over (x, y, theta) in the fixed frame, to the motion of that frame
/// about its origin.
Eigen::Matrix3d about_origin(const Pose2& fixed_from_base) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 2) = fixed_from_base.y;
  matrix(1, 2) = -fixed_from_base.x;
  return matrix;
}

/// The inverse of about_origin.
Eigen::Matrix3d at_pose(const Pose2& fixed_from_base) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 2) = -fixed_from_base.y;
  matrix(1, 2) = fixed_from_base.x;
  return matrix;
}

/// How far a match went by the map and not by its prior, as the two covariances tell: the gain of
/// a Kalman filter; the identity where the map says all, zero where it says nothing.
Eigen::Matrix3d gain_of(const Eigen::Matrix3d& prior, const Eigen::Matrix3d& match) {
  const Eigen::LLT<Eigen::Matrix3d> factor(prior);
  if (factor.info() != Eigen::Success) {
    return Eigen::Matrix3d::Zero();
  }
  const Eigen::Matrix3d root = factor.matrixL();
  const Eigen::Matrix3d inverse = root.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inverse * match * inverse.transpose());
  const Eigen::Vector3d gains = (1.0 - axes.eigenvalues().array()).max(0.0).min(1.0);
  return root * axes.eigenvectors() * gains.asDiagonal() * axes.eigenvectors().transpose() *
         inverse;
}

}  // namespace

KeyErrors::KeyErrors(const Pose2& fixed_from_key, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d to_error = about_origin(fixed_from_key);
  joint_ = to_error * covariance * to_error.transpose();
  positions_.push_back(fixed_from_key.translation());
}

Eigen::VectorXd KeyErrors::weights_at(const Pose2& fixed_from_base) const {
  // The walls that say most are near, and were measured best by the key scans near there. With this
  // the normalized errors in simulated rooms, clutter and corridors are 0.6 to 3.6; 3 is right.
  constexpr double kReach = 1.5;  // [m]
  Eigen::VectorXd weights(static_cast<Eigen::Index>(positions_.size()));
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const double away = (positions_[i] - fixed_from_base.translation()).norm() / kReach;
    // Somebody has to count, however far away.
    weights(static_cast<Eigen::Index>(i)) = std::max(std::exp(-0.5 * away * away), 1e-9);
  }
  return weights / weights.sum();
}

Eigen::Matrix3Xd KeyErrors::shares(const Pose2& fixed_from_base, const Eigen::Matrix3d& prior,
                                   const Eigen::Matrix3d& match) const {
  const Eigen::Matrix3d gain =
      about_origin(fixed_from_base) * gain_of(prior, match) * at_pose(fixed_from_base);
  const Eigen::VectorXd weights = weights_at(fixed_from_base);
  Eigen::Matrix3Xd result(3, joint_.cols());
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    result.middleCols<3>(3 * i) = weights(i) * gain;
  }
  result.rightCols<3>() += Eigen::Matrix3d::Identity() - gain;
  return result;
}

Eigen::Matrix3d KeyErrors::covariance_of(const Pose2& fixed_from_base, const Eigen::Matrix3d& prior,
                                         const Eigen::Matrix3d& match) const {
  const Eigen::Matrix3Xd from_keys =
      at_pose(fixed_from_base) * shares(fixed_from_base, prior, match);
  return from_keys * joint_ * from_keys.transpose() + match;
}

void KeyErrors::add(const Pose2& fixed_from_key, const Eigen::Matrix3d& prior,
                    const Eigen::Matrix3d& match) {
  const Eigen::Matrix3Xd from_keys = shares(fixed_from_key, prior, match);
  const Eigen::Matrix3d to_error = about_origin(fixed_from_key);
  const Eigen::Index old = joint_.rows();
  const Eigen::Matrix3Xd across = from_keys * joint_;
  Eigen::MatrixXd joint(old + 3, old + 3);
  joint << joint_, across.transpose(), across,
      across * from_keys.transpose() + to_error * match * to_error.transpose();
  joint_ = std::move(joint);
  positions_.push_back(fixed_from_key.translation());
}

void KeyErrors::keep_newest(std::size_t count) {
  if (count >= positions_.size()) {
    return;
  }
  positions_.erase(positions_.begin(), positions_.end() - static_cast<std::ptrdiff_t>(count));
  const auto kept = static_cast<Eigen::Index>(3 * count);
  joint_ = joint_.bottomRightCorner(kept, kept).eval();
}

}  // namespace matchbox_slam
