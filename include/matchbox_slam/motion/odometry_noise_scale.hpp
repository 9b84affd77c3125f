#pragma once

#include <Eigen/Core>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/motion/motion_prior.hpp"

namespace matchbox_slam {

/// Which share of the motion prior's standard deviations the errors of this odometry really have,
/// as its matches show: the prior is wide enough for bad wheels, and most are better. Where nothing
/// but odometry tells how far the robot came, as in a corridor, all depends on it.
struct OdometryNoiseScale {
  double translation = 1.0;
  double rotation = 1.0;
};

/// An estimate whose errors are by these shares of what its options make them.
[[nodiscard]] MotionEstimate scaled_by(const OdometryNoiseScale& scale, MotionEstimate estimate);

/// What a match teaches about the odometry that predicted it. An error of the prediction by
/// which the match could tell it, in each direction, is compared with what the prior makes of it
/// (covariance matching by innovations, Mehra, "Approaches to Adaptive Filtering", 1972). What the
/// match could not tell teaches nothing, nor does a robot at rest: shares follow the errors over
/// the last metres of way. That of the translation is one for both directions: in a corridor the
/// walls teach what counts along it, too.
/// @param moved       since the scan before, by odometry.
/// @param predicted, matched  poses of the base in one fixed frame.
/// @param prior, posterior    their covariances over (x [m], y [m], theta [rad]) in that frame.
/// @param min_scale   no share gets smaller.
[[nodiscard]] OdometryNoiseScale updated_noise_scale(const OdometryNoiseScale& scale,
                                                     const Pose2& moved, const Pose2& predicted,
                                                     const Eigen::Matrix3d& prior,
                                                     const Pose2& matched,
                                                     const Eigen::Matrix3d& posterior,
                                                     double min_scale);

}  // namespace matchbox_slam
