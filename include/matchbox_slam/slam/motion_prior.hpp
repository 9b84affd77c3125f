#pragma once

#include <Eigen/Core>
#include <optional>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

struct MotionPriorOptions {
  double translation_per_metre = 0.3;
  double translation_per_radian = 0.1;
  double translation_floor = 0.03;
  double rotation_per_radian = 0.3;
  double rotation_per_metre = 0.15;
  double rotation_floor = 0.01;
  double velocity_change = 1.0;
  double turn_rate_change = 2.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.translation_per_metre, "translation_per_metre", between(0.0, 10.0), "m/m",
           "Standard deviation of the odometry's position per metre driven.");
    option(self.translation_per_radian, "translation_per_radian", between(0.0, 10.0), "m/rad",
           "Standard deviation of the odometry's position per radian turned.");
    option(self.translation_floor, "translation_floor", between(0.0, 10.0), "m",
           "Standard deviation of the position that every prediction has.");
    option(self.rotation_per_radian, "rotation_per_radian", between(0.0, 10.0), "rad/rad",
           "Standard deviation of the odometry's heading per radian turned.");
    option(self.rotation_per_metre, "rotation_per_metre", between(0.0, 10.0), "rad/m",
           "Standard deviation of the odometry's heading per metre driven.");
    option(self.rotation_floor, "rotation_floor", between(0.0, 10.0), "rad",
           "Standard deviation of the heading that every prediction has.");
    option(self.velocity_change, "velocity_change", between(0.0, 100.0), "m/s",
           "Without odometry: how much the velocity may change from scan to scan.");
    option(self.turn_rate_change, "turn_rate_change", between(0.0, 100.0), "rad/s",
           "Without odometry: how much the turn rate may change from scan to scan.");
  }
};

/// How far the base moved between two scans, and how well that is known.
struct MotionEstimate {
  Pose2 previous_from_current;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< in the previous base frame
};

/// The motion between two readings of odometry, taken in the base frame: what the odometry's own
/// heading was does not matter.
[[nodiscard]] MotionEstimate motion_from_odometry(const Pose2& odom_from_previous,
                                                  const Pose2& odom_from_current,
                                                  const MotionPriorOptions& options);

/// Without odometry: the last motion goes on at the same speed.
/// @param last_motion  motion of the base over `last_interval` seconds.
/// @param interval     seconds to predict.
[[nodiscard]] MotionEstimate motion_at_constant_velocity(const Pose2& last_motion,
                                                         double last_interval, double interval,
                                                         const MotionPriorOptions& options);

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
