#pragma once

#include <Eigen/Core>

namespace matchbox_slam {

/// Covariance over (x, y, theta) of a pose whose position and heading are known apart from each
/// other, by their standard deviations.
/// @param sigma_xy     [m], of x and of y.
/// @param sigma_theta  [rad]
[[nodiscard]] inline Eigen::Matrix3d covariance_of(double sigma_xy, double sigma_theta) {
  return Eigen::Vector3d(sigma_xy, sigma_xy, sigma_theta).cwiseAbs2().asDiagonal();
}

}  // namespace matchbox_slam
