#pragma once

#include <Eigen/Core>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/motion/odometry_calibration.hpp"
#include "matchbox_slam/motion/odometry_noise_scale.hpp"

namespace matchbox_slam {

/// What the motion from scan to scan is predicted from.
enum class GuessSource {
  kVelocity,  ///< the last motion goes on
  kOdometry,  ///< of wheels, say; the last motion for scans without
  kHeading,   ///< the turn from the input's odometry, an IMU's; the way from the last motion; so
              ///< it is for any scan whose odometry is a heading only
};

/// All that a motion tracker knows: a value, to be copied and saved. Poses are those of the base in
/// one fixed frame, the map's or that of an odometry.
struct MotionState {
  /// A scan that was matched, or that started a map.
  struct Fix {
    double stamp = 0.0;  ///< [s]
    Pose2 fixed_from_base;
  };
  Pose2 fixed_from_base;  ///< at the newest scan; before there is one, at the first
  /// Over (x, y, theta) in the fixed frame, without the floor of the prediction.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// The part of the error that the velocity's error made; see MotionPrediction.
  Eigen::Matrix3d by_velocity = Eigen::Matrix3d::Zero();
  std::optional<double> stamp;          ///< [s] of the newest scan
  int laser = 0;                        ///< of the newest scan
  bool matched = false;                 ///< whether the newest scan is a fix
  std::optional<Pose2> odom_from_base;  ///< by the newest scan's odometry
  std::optional<Fix> fix;               ///< the newest one
  /// As the base moves, by the base frame at its begin: between the last two fixes by odometry,
  /// else by the velocity that fixes tell.
  Pose2 motion;
  double interval = 0.0;  ///< [s] that this motion took; 0: none is known
  OdometryNoiseScale noise_scale;
  OdometryCalibration calibration;

  /// By that: (x [m/s], y [m/s], theta [rad/s]) in the base frame.
  [[nodiscard]] Eigen::Vector3d velocity() const {
    return interval > 0.0
               ? Eigen::Vector3d(Eigen::Vector3d(motion.x, motion.y, motion.theta) / interval)
               : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
};

}  // namespace matchbox_slam
