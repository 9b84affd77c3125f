#pragma once

#include <Eigen/Core>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// Systematic errors of an odometry: wheels that are not as large, not as far apart or not as equal
/// as it takes them to be (Borenstein and Feng, "Measurement and Correction of Systematic Odometry
/// Errors in Mobile Robots", 1996). Where nothing but odometry tells how far the robot came, as in
/// a corridor, they add up; the rooms before it tell what they are.
struct OdometryCalibration {
  /// Of the drive, each scan of it matched in all directions.
  struct Stretch {
    double stamp = 0.0;       ///< [s] of its newest scan
    Pose2 fixed_from_first;   ///< where it began
    Pose2 first_from_newest;  ///< by odometry as it is calibrated
    double forward = 0.0;     ///< [m] by odometry; backwards counts less than zero
    double turn = 0.0;        ///< [rad] by odometry; to the right counts less than zero
    double length = 0.0;      ///< [m] of way, turns counted in
  };
  /// What is missing in odometry: of the way [m/m], of the turn [rad/rad], and of the turn by the
  /// way that was driven forward [rad/m].
  Eigen::Vector3d missing = Eigen::Vector3d::Zero();
  /// Of these. As unsure of it as robots' odometry is wrong at first: 0.3 to 3 %, 0 to 0.06 rad/m
  /// in six recordings.
  Eigen::Matrix3d covariance = Eigen::Vector3d(9e-4, 9e-4, 4e-4).asDiagonal();
  /// Variances of what else it is off by: way [m^2/m], turn [rad^2/m].
  Eigen::Vector2d noise = {1.6e-3, 1.6e-3};
  std::optional<Stretch> stretch;
};

/// A motion that odometry tells, with what is missing: that of the turn came evenly along the way.
[[nodiscard]] Pose2 calibrated(const OdometryCalibration& calibration, const Pose2& moved);

/// A scan that was matched, and what odometry said.
struct CalibrationStep {
  double stamp_before = 0.0;                            ///< [s] of the scan before
  double stamp = 0.0;                                   ///< [s]
  Pose2 moved;                                          ///< between them, by odometry alone
  Pose2 fixed_from_base;                                ///< by the match, in any fixed frame
  Eigen::Matrix3d prior = Eigen::Matrix3d::Zero();      ///< over (x, y, theta) in that frame
  Eigen::Matrix3d posterior = Eigen::Matrix3d::Zero();  ///< the same, with the match
};

/// What a match teaches of systematic errors: a Kalman filter, its noise as large as the
/// innovations show it to be, that is given a metre of the drive at a time. From scan to scan,
/// where the noise of odometry is as large as its motion, it would learn that noise: both sides of
/// a regression have it. Where the robot is held by its prior alone nothing is learned. One stretch
/// counts as off by three times the usual at most, since wheels slip.
[[nodiscard]] OdometryCalibration calibrate(OdometryCalibration calibration,
                                            const CalibrationStep& step);

}  // namespace matchbox_slam
