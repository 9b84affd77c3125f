#include "matchbox_slam/motion/motion_prior.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

double square(double value) { return value * value; }

Eigen::Matrix3d diagonal(double xy, double theta) {
  return Eigen::Vector3d(xy, xy, theta).asDiagonal();
}

/// What errors (x, y, theta) a `share` of the motion before its end become at the end: that of the
/// heading moves it sideways.
Eigen::Matrix3d at_the_end(const Pose2& motion, double share) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 2) = -share * motion.y;
  matrix(1, 2) = share * motion.x;
  return matrix;
}

/// Covariance at the end of a motion along which errors come evenly.
Eigen::Matrix3d grown_along(const Pose2& motion, double variance_xy, double variance_theta) {
  const Eigen::Matrix3d middle = at_the_end(motion, 0.5);
  Eigen::Matrix3d grown = middle * diagonal(variance_xy, variance_theta) * middle.transpose();
  const Eigen::Vector2d sideways(-motion.y, motion.x);
  grown.topLeftCorner<2, 2>() += variance_theta / 12.0 * sideways * sideways.transpose();
  return grown;
}

}  // namespace

double way_with_turn(const Pose2& moved) {
  constexpr double kMetresPerRadian = 0.3;  // a guess (CONSTANTS.md)
  return moved.translation().norm() + kMetresPerRadian * std::abs(moved.theta);
}

MotionEstimate motion_from_odometry(const Pose2& odom_from_previous, const Pose2& odom_from_current,
                                    double interval, const MotionPriorOptions& options) {
  MotionEstimate estimate;
  estimate.is_by_odometry = true;
  const Pose2 motion = odom_from_previous.inverse() * odom_from_current;
  const double way = motion.translation().norm();
  const double turn = std::abs(motion.theta);
  estimate.previous_from_current = motion;
  estimate.covariance = grown_along(
      motion,
      square(options.translation_by_way) * way + square(options.translation_by_turn) * turn +
          square(options.translation_by_time) * interval,
      square(options.rotation_by_way) * way + square(options.rotation_by_turn) * turn +
          square(options.rotation_by_time) * interval);
  estimate.floor = diagonal(square(options.translation_floor), square(options.rotation_floor));
  estimate.unscaled = estimate.covariance + estimate.floor;
  return estimate;
}

MotionEstimate motion_at_constant_velocity(const Pose2& last_motion, double last_interval,
                                           double interval, const MotionPriorOptions& options) {
  MotionEstimate estimate;
  if (last_interval > 0.0) {
    estimate.previous_from_current = interpolate(Pose2{}, last_motion, interval / last_interval);
  }
  estimate.by_velocity = interval * at_the_end(estimate.previous_from_current, 0.5) *
                         diagonal(options.velocity_change, options.turn_rate_change);
  estimate.covariance = estimate.by_velocity * estimate.by_velocity.transpose();
  estimate.floor = diagonal(square(options.translation_floor), square(options.rotation_floor));
  estimate.unscaled = estimate.covariance + estimate.floor;
  return estimate;
}

MotionEstimate with_measured_turn(MotionEstimate motion, double turn, double sigma) {
  motion.previous_from_current.theta = turn;
  motion.by_velocity.col(2).setZero();
  motion.covariance = motion.by_velocity * motion.by_velocity.transpose();
  motion.floor(2, 2) = square(sigma);
  motion.unscaled = motion.covariance + motion.floor;
  return motion;
}

Eigen::Matrix3d left_by_match(const Eigen::Matrix3d& prior, const Eigen::Matrix3d& match) {
  const Eigen::LLT<Eigen::Matrix3d> factor(prior);
  if (factor.info() != Eigen::Success) {
    return Eigen::Matrix3d::Identity();
  }
  const Eigen::Matrix3d root = factor.matrixL();
  const Eigen::Matrix3d inverse = root.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inverse * match * inverse.transpose());
  const Eigen::Vector3d left = axes.eigenvalues().array().max(0.0).min(1.0);
  return root * axes.eigenvectors() * left.asDiagonal() * axes.eigenvectors().transpose() * inverse;
}

Pose2 without_overshoot(const Pose2& predicted, const Pose2& matched, double sweep) {
  constexpr double kMeanBeam = 0.5;  // of the sweep
  return interpolate(predicted, matched, 1.0 / (1.0 + kMeanBeam * std::max(0.0, sweep)));
}

}  // namespace matchbox_slam
