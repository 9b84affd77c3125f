#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace matchbox_slam {

/// Covariance over (x, y, theta) of a pose whose position and heading are known apart from each
/// other, by their standard deviations.
/// @param sigma_xy     [m], of x and of y.
/// @param sigma_theta  [rad]
[[nodiscard]] inline Eigen::Matrix3d covariance_of(double sigma_xy, double sigma_theta) {
  return Eigen::Vector3d(sigma_xy, sigma_xy, sigma_theta).cwiseAbs2().asDiagonal();
}

/// The covariance over (x, y, theta) of a pose, told in the axes of a frame that is turned by
/// `theta` [rad] against those that it is given in.
[[nodiscard]] inline Eigen::Matrix3d in_turned_frame(const Eigen::Matrix3d& covariance,
                                                     double theta) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-theta).toRotationMatrix();
  return turn * covariance * turn.transpose();
}

/// Mean of a matrix and its transpose: rounding leaves products that ought to be symmetric not
/// quite so.
[[nodiscard]] inline Eigen::Matrix3d symmetric(const Eigen::Matrix3d& matrix) {
  return 0.5 * (matrix + matrix.transpose());
}

}  // namespace matchbox_slam
