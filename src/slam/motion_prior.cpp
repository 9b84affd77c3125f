#include "matchbox_slam/slam/motion_prior.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

double square(double value) { return value * value; }

Eigen::Matrix3d diagonal(double variance_xy, double variance_theta) {
  return Eigen::Vector3d(variance_xy, variance_xy, variance_theta).asDiagonal();
}

}  // namespace

MotionEstimate motion_from_odometry(const Pose2& odom_from_previous, const Pose2& odom_from_current,
                                    const MotionPriorOptions& options) {
  MotionEstimate estimate;
  estimate.previous_from_current = odom_from_previous.inverse() * odom_from_current;
  const double distance = estimate.previous_from_current.translation().norm();
  const double turn = std::abs(estimate.previous_from_current.theta);
  estimate.covariance =
      diagonal(square(options.translation_floor + options.translation_per_metre * distance +
                      options.translation_per_radian * turn),
               square(options.rotation_floor + options.rotation_per_radian * turn +
                      options.rotation_per_metre * distance));
  return estimate;
}

MotionEstimate motion_at_constant_velocity(const Pose2& last_motion, double last_interval,
                                           double interval, const MotionPriorOptions& options) {
  MotionEstimate estimate;
  if (last_interval > 0.0) {
    estimate.previous_from_current = interpolate(Pose2{}, last_motion, interval / last_interval);
  }
  estimate.covariance =
      diagonal(square(options.translation_floor + options.velocity_change * interval),
               square(options.rotation_floor + options.turn_rate_change * interval));
  return estimate;
}

Pose2 without_overshoot(const Pose2& predicted, const Pose2& matched, double sweep) {
  constexpr double kMeanBeam = 0.5;  // of the sweep
  return interpolate(predicted, matched, 1.0 / (1.0 + kMeanBeam * std::max(0.0, sweep)));
}

}  // namespace matchbox_slam
