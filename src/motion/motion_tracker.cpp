#include "motion/motion_tracker.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>

#include "matchbox_slam/geometry/chi_square.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {
namespace {

// [rad], standard deviation of a turn from scan to scan by an IMU, where nobody has set it.
constexpr double kImuTurnSigma = 0.02;

}  // namespace

void MotionTracker::check(const ScanInput& input) const {
  const auto scan = [&input] { return "scan at " + std::to_string(input.scan.stamp) + " s"; };
  const bool is_later = !state_.stamp || input.scan.stamp > *state_.stamp ||
                        (input.scan.stamp == *state_.stamp && input.laser != state_.laser);
  if (!is_later) {
    throw std::invalid_argument(scan() + " is not later than the one before, at " +
                                std::to_string(*state_.stamp) + " s; process scans in order");
  }
  if (input.odometry && !(input.odometry->odom_from_base.is_finite() &&
                          input.odometry->odom_from_base_last_beam.is_finite())) {
    throw std::invalid_argument("the odometry of the " + scan() +
                                " is no number; leave it out to go on without odometry");
  }
  if (!(input.base_from_laser * input.laser_motion).matrix().allFinite()) {
    throw std::invalid_argument("the laser's pose for the " + scan() + " is no number");
  }
}

MotionPrediction MotionTracker::predict(const ScanInput& input) const {
  check(input);
  if (state_.stamp) {
    return predict_by(motion_since_newest(input), input);
  }
  MotionPrediction predicted;
  predicted.fixed_from_base = state_.fixed_from_base;
  predicted.covariance = state_.covariance;
  predicted.search_covariance = state_.covariance;
  predicted.during_scan = motion_during_scan(input, state_.motion, state_.interval);
  return predicted;
}

std::optional<MotionPrediction> MotionTracker::predict_steadily(const ScanInput& input) const {
  if (!has_odometry(input) || !state_.odom_from_base) {
    return std::nullopt;
  }
  const double interval = input.scan.stamp - *state_.stamp;
  return is_improbable(motion_since_newest(input).previous_from_current, interval)
             ? std::optional(predict_by(steady_motion(interval), input))
             : std::nullopt;
}

/// Whether robots hardly ever move so in this time that have just moved as this one did: by the
/// usual changes of their velocity and what its last two poses make that uncertain.
bool MotionTracker::is_improbable(const Pose2& moved, double interval) const {
  // [m/s], standard deviation of the change of velocity, at least. A change four times as large is
  // doubted: it is as fast as robots drive in buildings.
  constexpr double kMinVelocityChange = 0.5;
  if (!state_.matched || state_.interval <= 0.0) {  // its motion is not known
    return false;
  }
  MotionPriorOptions options = options_;
  options.velocity_change = std::max(options.velocity_change, kMinVelocityChange);
  const MotionEstimate steady =
      motion_at_constant_velocity(state_.motion, state_.interval, interval, options);
  const double share = interval / state_.interval;
  const Eigen::Vector3d off = difference(moved, steady.previous_from_current);
  const Eigen::Matrix3d covariance = steady.covariance + (1.0 + share * share) * steady.floor;
  return off.dot(covariance.ldlt().solve(off)) > kMostChiSquare;
}

/// Whether odometry tells how the base moves during the scan: one that is set meanwhile would tear
/// the scan.
bool MotionTracker::measures_sweep(const ScanInput& input) const {
  return has_odometry(input) && !is_improbable(input.odometry->odom_from_base.inverse() *
                                                   input.odometry->odom_from_base_last_beam,
                                               input.scan.duration());
}

MotionPrediction MotionTracker::predict_by(const MotionEstimate& motion,
                                           const ScanInput& input) const {
  MotionPrediction predicted;
  predicted.motion = motion;
  predicted.fixed_from_base = state_.fixed_from_base * motion.previous_from_current;
  add_errors(predicted);
  predicted.during_scan = motion_during_scan(input, state_.motion, state_.interval);
  return predicted;
}

/// An error of the velocity adds to what it did since the last match: that part of the variance
/// grows with the square of the time, and by products of both.
void MotionTracker::add_errors(MotionPrediction& predicted) const {
  const MotionEstimate& motion = predicted.motion;
  const Eigen::Vector2d way =
      predicted.fixed_from_base.translation() - state_.fixed_from_base.translation();
  Eigen::Matrix3d moved = Eigen::Matrix3d::Identity();
  moved.topRightCorner<2, 1>() << -way.y(), way.x();
  const Eigen::Matrix3d since_match = moved * state_.by_velocity;
  const Eigen::Matrix3d added = in_turned_frame(motion.by_velocity, -state_.fixed_from_base.theta);
  const Eigen::Matrix3d both = since_match * added.transpose();
  predicted.by_velocity = since_match + added;
  predicted.covariance =
      compose_covariance(state_.fixed_from_base, state_.covariance, motion.previous_from_current,
                         motion.covariance + motion.floor) +
      both + both.transpose();
  predicted.search_covariance = compose_covariance(state_.fixed_from_base, state_.covariance,
                                                   motion.previous_from_current, motion.unscaled) +
                                both + both.transpose();
}

MotionEstimate MotionTracker::motion_since_newest(const ScanInput& input) const {
  const double interval = input.scan.stamp - *state_.stamp;
  if (has_odometry(input) && state_.odom_from_base) {
    MotionEstimate estimate =
        scaled_by(state_.noise_scale,
                  motion_from_odometry(*state_.odom_from_base, input.odometry->odom_from_base,
                                       interval, options_));
    if (options_.calibrate) {
      estimate.previous_from_current =
          calibrated(state_.calibration, estimate.previous_from_current);
    }
    return estimate;
  }
  MotionEstimate motion = steady_motion(interval);
  if (has_heading(input) && state_.odom_from_base) {
    return with_measured_turn(
        motion, wrap_angle(input.odometry->odom_from_base.theta - state_.odom_from_base->theta),
        source_ == GuessSource::kHeading ? heading_sigma_ : kImuTurnSigma);
  }
  return motion;
}

Pose2 MotionTracker::motion_during_scan(const ScanInput& input, const Pose2& moved,
                                        double interval) const {
  if (measures_sweep(input)) {
    return input.odometry->odom_from_base.inverse() * input.odometry->odom_from_base_last_beam;
  }
  Pose2 motion;
  if (interval > 0.0) {
    motion = interpolate(Pose2{}, moved, input.scan.duration() / interval);
  }
  if (has_heading(input)) {
    motion.theta = wrap_angle(input.odometry->odom_from_base_last_beam.theta -
                              input.odometry->odom_from_base.theta);
  }
  return motion;
}

MatchedMotion MotionTracker::after_match(const ScanInput& input, const MotionPrediction& predicted,
                                         const MatchResult& match) const {
  MatchedMotion matched{match.map_from_base, predicted.during_scan};
  const double passed = state_.fix ? input.scan.stamp - state_.fix->stamp : 0.0;
  if (!match.accepted() || measures_sweep(input) ||
      !(passed > 0.0 && input.scan.duration() > 0.0)) {
    return matched;
  }
  matched.fixed_from_base = without_overshoot(predicted.fixed_from_base, match.map_from_base,
                                              input.scan.duration() / passed);
  if (has_heading(input)) {  // the turn was measured, so that nothing went too far in it
    matched.fixed_from_base.theta = match.map_from_base.theta;
  }
  const Pose2 moved = state_.fix->fixed_from_base.inverse() * matched.fixed_from_base;
  matched.during_scan = motion_during_scan(input, moved, passed);
  return matched;
}

void MotionTracker::learn(const ScanInput& input, const MotionPrediction& predicted,
                          const MatchResult& match) {
  if (!has_odometry(input) || !state_.odom_from_base) {
    return;
  }
  if (!predicted.motion.is_by_odometry) {
    state_.noise_scale = {};  // it told of a step that was none
  } else if (state_.matched) {
    state_.noise_scale = updated_noise_scale(
        state_.noise_scale, predicted.motion.previous_from_current, predicted.fixed_from_base,
        predicted.covariance, match.map_from_base, match.covariance, options_.min_noise_scale);
    if (options_.calibrate) {
      state_.calibration = calibrate(
          state_.calibration, {*state_.stamp, input.scan.stamp,
                               state_.odom_from_base->inverse() * input.odometry->odom_from_base,
                               match.map_from_base, predicted.covariance, match.covariance});
    }
  }
}

void MotionTracker::remember(const ScanInput& input, const MotionPrediction& predicted,
                             const Pose2& fixed_from_base, const Eigen::Matrix3d& covariance,
                             bool matched) {
  if (matched) {
    // From fix to fix: what a wrong prediction was corrected by is no motion.
    if (state_.fix && input.scan.stamp > state_.fix->stamp) {
      if (predicted.motion.is_by_odometry) {
        state_.motion = state_.fix->fixed_from_base.inverse() * fixed_from_base;
        state_.interval = input.scan.stamp - state_.fix->stamp;
      } else {
        correct_velocity(input.scan.stamp - *state_.stamp, predicted, fixed_from_base);
      }
    }
    state_.fix = MotionState::Fix{input.scan.stamp, fixed_from_base};
  }
  // A floor counts once, and the next prediction adds its own: what the match left of it goes out.
  const Eigen::Matrix3d left = left_by_match(predicted.covariance, covariance);
  state_.covariance = covariance - left * predicted.motion.floor * left.transpose();
  state_.by_velocity = left * predicted.by_velocity;
  state_.fixed_from_base = fixed_from_base;
  state_.stamp = input.scan.stamp;
  state_.laser = input.laser;
  state_.matched = matched;
  state_.odom_from_base.reset();
  if (input.odometry) {
    state_.odom_from_base = input.odometry->odom_from_base;
  }
}

/// What the match corrected is put down to the velocity as far as its error made that of the pose:
/// an error that nothing told of for ten scans is a tenth as fast as one of the last scan.
void MotionTracker::correct_velocity(double interval, const MotionPrediction& predicted,
                                     const Pose2& fixed_from_base) {
  const Eigen::LDLT<Eigen::Matrix3d> prior(predicted.covariance);
  if (!(interval > 0.0) || prior.info() != Eigen::Success) {
    return;
  }
  const Eigen::Vector3d corrected = difference(fixed_from_base, predicted.fixed_from_base);
  const Eigen::Vector3d sigmas = predicted.by_velocity.transpose() * prior.solve(corrected);
  const Eigen::Vector2d velocity = Eigen::Rotation2Dd(-fixed_from_base.theta) *
                                   Eigen::Vector2d(options_.velocity_change * sigmas.head<2>());
  const Pose2& steady = predicted.motion.previous_from_current;
  state_.motion = {steady.x + interval * velocity.x(), steady.y + interval * velocity.y(),
                   steady.theta + interval * options_.turn_rate_change * sigmas.z()};
  state_.interval = interval;
}

void MotionTracker::set_pose(const Pose2& fixed_from_base, const Eigen::Matrix3d& covariance) {
  state_.fixed_from_base = fixed_from_base;
  state_.covariance = covariance;
  state_.by_velocity.setZero();
  state_.fix.reset();
  state_.calibration.stretch.reset();
  if (!state_.matched) {  // else the base goes on as it did
    forget_motion();
  }
}

void MotionTracker::change_frame(const Pose2& new_from_fixed) {
  state_.fixed_from_base = new_from_fixed * state_.fixed_from_base;
  state_.covariance = in_turned_frame(state_.covariance, -new_from_fixed.theta);
  state_.by_velocity = in_turned_frame(state_.by_velocity, -new_from_fixed.theta);
  if (auto& stretch = state_.calibration.stretch) {
    stretch->fixed_from_first = new_from_fixed * stretch->fixed_from_first;
  }
  if (state_.fix) {
    state_.fix->fixed_from_base = new_from_fixed * state_.fix->fixed_from_base;
  }
}

void MotionTracker::forget_motion() {
  state_.motion = {};
  state_.interval = 0.0;
}

}  // namespace matchbox_slam
