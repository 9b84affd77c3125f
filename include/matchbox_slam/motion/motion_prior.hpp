#pragma once

#include <Eigen/Core>
#include <optional>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// How the uncertainty of a prediction grows since the last match. What odometry adds is a random
/// walk: its variance grows in proportion to way, turn and time, however many scans cut them up.
struct MotionPriorOptions {
  double translation_by_way = 0.25;
  double translation_by_turn = 0.1;
  double translation_by_time = 0.14;
  double translation_floor = 0.02;
  double rotation_by_turn = 0.18;
  double rotation_by_way = 0.06;
  double rotation_by_time = 0.06;
  double rotation_floor = 0.005;
  double velocity_change = 0.3;
  double turn_rate_change = 2.0;
  double min_noise_scale = 0.2;
  bool calibrate = true;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.translation_by_way, "translation_by_way", between(0.0, 10.0), "m/sqrt(m)",
           "Standard deviation of the odometry's position after one metre driven; it grows with "
           "the square root of the way.");
    option(self.translation_by_turn, "translation_by_turn", between(0.0, 10.0), "m/sqrt(rad)",
           "Standard deviation of the odometry's position after one radian turned.");
    option(self.translation_by_time, "translation_by_time", between(0.0, 10.0), "m/sqrt(s)",
           "Standard deviation of the odometry's position after one second, at rest too.");
    option(self.translation_floor, "translation_floor", between(1e-6, 10.0), "m",
           "Standard deviation of the position that a prediction has besides, once.");
    option(self.rotation_by_turn, "rotation_by_turn", between(0.0, 10.0), "rad/sqrt(rad)",
           "Standard deviation of the odometry's heading after one radian turned.");
    option(self.rotation_by_way, "rotation_by_way", between(0.0, 10.0), "rad/sqrt(m)",
           "Standard deviation of the odometry's heading after one metre driven.");
    option(self.rotation_by_time, "rotation_by_time", between(0.0, 10.0), "rad/sqrt(s)",
           "Standard deviation of the odometry's heading after one second, at rest too.");
    option(self.rotation_floor, "rotation_floor", between(1e-6, 10.0), "rad",
           "Standard deviation of the heading that a prediction has besides, once.");
    option(self.velocity_change, "velocity_change", between(0.0, 100.0), "m/s",
           "Without odometry: standard deviation of the change of the velocity since the last "
           "match.");
    option(self.turn_rate_change, "turn_rate_change", between(0.0, 100.0), "rad/s",
           "Without odometry: standard deviation of the change of the turn rate since the last "
           "match.");
    option(self.min_noise_scale, "min_noise_scale", between(0.01, 1.0), "",
           "The standard deviations of odometry go down to this share of what is set, as matches "
           "show that it is better; 1: they stay as set.");
    option(self.calibrate, "calibrate", any(), "",
           "Learn from matches by which share odometry tells too little of way and turn, and how "
           "much it turns by the way, and correct it.");
  }
};

/// How far the base moved between two scans, and how well that is known; matrices are over (x, y,
/// theta) in the previous base frame.
struct MotionEstimate {
  Pose2 previous_from_current;
  bool is_by_odometry = false;                           ///< else the last motion goes on
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< that this motion adds
  /// Of a single reading, as of odometry: no part of the next motion's error, which adds its own.
  Eigen::Matrix3d floor = Eigen::Matrix3d::Zero();
  /// Covariance and floor as they were said to be, before matches taught that they are less.
  Eigen::Matrix3d unscaled = Eigen::Matrix3d::Zero();
  /// Column i: the error (x, y, theta) by a velocity that is off by one standard deviation in i. It
  /// is off by the same until the next match, so these add up. Part of the covariance.
  Eigen::Matrix3d by_velocity = Eigen::Matrix3d::Zero();
};

/// [m] of way that a motion counts as, for what drifts and what is learned along it: a turn counts
/// as so much way, too.
[[nodiscard]] double way_with_turn(const Pose2& moved);

/// The motion between two readings of odometry, taken in the base frame: what the odometry's own
/// heading was does not matter.
/// @param interval  [s] between the readings.
[[nodiscard]] MotionEstimate motion_from_odometry(const Pose2& odom_from_previous,
                                                  const Pose2& odom_from_current, double interval,
                                                  const MotionPriorOptions& options);

/// Without odometry: the last motion goes on at the same speed.
/// @param last_motion  motion of the base over `last_interval` seconds.
/// @param interval     seconds to predict.
[[nodiscard]] MotionEstimate motion_at_constant_velocity(const Pose2& last_motion,
                                                         double last_interval, double interval,
                                                         const MotionPriorOptions& options);

/// The turn as a heading says that was measured, with this standard deviation [rad].
[[nodiscard]] MotionEstimate with_measured_turn(MotionEstimate motion, double turn, double sigma);

/// Share of the prior's error that a match leaves, as the two covariances tell: zero where the map
/// says all, the identity where it says nothing or the prior has no inverse.
[[nodiscard]] Eigen::Matrix3d left_by_match(const Eigen::Matrix3d& prior,
                                            const Eigen::Matrix3d& match);

/// The pose at a scan whose motion during the sweep was predicted from earlier matches, and so
/// taken out wrongly where the prediction is wrong. With a prediction that is off by d since the
/// last match, the points are off by d / 2 times `sweep` on average, to the other side: the match
/// goes too far from the prediction, by as much. The next prediction would go too far back, and so
/// on, with more and more; a laser that sweeps all the time had poses that swing by themselves. The
/// motion of the pose is less than that of the match by this share, to first order.
/// @param predicted, matched  poses of the base in the map, or in the odometry's frame.
/// @param sweep  duration of the scan over the time since the last match; above 1 where several
///               lasers take turns.
[[nodiscard]] Pose2 without_overshoot(const Pose2& predicted, const Pose2& matched, double sweep);

}  // namespace matchbox_slam
