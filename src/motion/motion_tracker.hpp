#pragma once

#include <Eigen/Core>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/motion/motion_prior.hpp"
#include "matchbox_slam/motion/motion_state.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"

namespace matchbox_slam {

/// What is known of a scan before it is matched.
struct MotionPrediction {
  Pose2 fixed_from_base;                                 ///< at the scan's stamp
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< over (x, y, theta) in the fixed frame
  /// The same by what odometry was said to be, whatever matches taught of it since.
  Eigen::Matrix3d search_covariance = Eigen::Matrix3d::Zero();
  MotionEstimate motion;  ///< since the newest scan
  /// What of the pose's error was made by the velocity's, in the fixed frame; see MotionEstimate.
  Eigen::Matrix3d by_velocity = Eigen::Matrix3d::Zero();
  Pose2 during_scan;  ///< pose of the base at the last beam in the base at the first
};

/// What is known of it afterwards.
struct MatchedMotion {
  Pose2 fixed_from_base;  ///< at the scan's stamp; see without_overshoot
  Pose2 during_scan;      ///< as in MotionPrediction, by the motion as it is known now
};

/// Follows the base from scan to scan: predicts where it is and how it moves during the scan, and
/// learns from what became of the match.
class MotionTracker {
 public:
  /// @param heading_sigma  [rad] standard deviation of a turn from scan to scan by kHeading.
  explicit MotionTracker(const MotionPriorOptions& options,
                         GuessSource source = GuessSource::kOdometry, double heading_sigma = 0.0)
      : options_(options), source_(source), heading_sigma_(heading_sigma) {}

  /// Predicts the next scan. Scans come in order of their stamps; those of different lasers may
  /// have the same one.
  /// Throws std::invalid_argument when a stamp is not later than the one before, or odometry or the
  /// laser's pose is no number.
  [[nodiscard]] MotionPrediction predict(const ScanInput& input) const;

  /// The prediction by the last motion alone, where what odometry tells of this step is improbable
  /// for a robot that has moved like that: it was set, say, or catches up after it hung. The input
  /// is one that predict() takes.
  [[nodiscard]] std::optional<MotionPrediction> predict_steadily(const ScanInput& input) const;

  /// What a match, accepted or not, says of the scan that was predicted so.
  [[nodiscard]] MatchedMotion after_match(const ScanInput& input, const MotionPrediction& predicted,
                                          const MatchResult& match) const;

  /// Learns how good odometry is, from a match that nothing speaks against. Where that was
  /// predicted by the last motion though odometry told of one, odometry may have become as bad as
  /// the options say; a scan without odometry says nothing of it. Before remember().
  void learn(const ScanInput& input, const MotionPrediction& predicted, const MatchResult& match);

  /// Takes a scan as the newest one.
  /// @param predicted   of this scan.
  /// @param covariance  of its pose, that the next prediction's starts with.
  /// @param matched     whether the pose comes from a map, or starts one.
  void remember(const ScanInput& input, const MotionPrediction& predicted,
                const Pose2& fixed_from_base, const Eigen::Matrix3d& covariance, bool matched);

  /// Says where the base was at the newest scan, or will be at the first one. Its motion goes on if
  /// that scan was matched.
  void set_pose(const Pose2& fixed_from_base, const Eigen::Matrix3d& covariance);

  /// Goes on in another fixed frame.
  void change_frame(const Pose2& new_from_fixed);

  /// Without odometry the base counts as at rest, until the next two fixes.
  void forget_motion();

  [[nodiscard]] const MotionState& state() const { return state_; }
  void set_state(const MotionState& state) { state_ = state; }
  void set_options(const MotionPriorOptions& options) { options_ = options; }

 private:
  void check(const ScanInput& input) const;
  [[nodiscard]] MotionEstimate steady_motion(double interval) const {
    return motion_at_constant_velocity(state_.motion, state_.interval, interval, options_);
  }
  [[nodiscard]] MotionPrediction predict_by(const MotionEstimate& motion,
                                            const ScanInput& input) const;
  [[nodiscard]] bool is_improbable(const Pose2& moved, double interval) const;
  [[nodiscard]] bool measures_sweep(const ScanInput& input) const;
  void add_errors(MotionPrediction& predicted) const;
  void correct_velocity(double interval, const MotionPrediction& predicted,
                        const Pose2& fixed_from_base);
  [[nodiscard]] MotionEstimate motion_since_newest(const ScanInput& input) const;
  /// @param moved  motion of the base in `interval` seconds, which is that of the scan too where
  ///               none was measured.
  [[nodiscard]] Pose2 motion_during_scan(const ScanInput& input, const Pose2& moved,
                                         double interval) const;
  [[nodiscard]] bool has_odometry(const ScanInput& input) const {
    return source_ == GuessSource::kOdometry && input.odometry && !input.odometry->is_heading_only;
  }
  [[nodiscard]] bool has_heading(const ScanInput& input) const {
    return input.odometry &&
           (source_ == GuessSource::kHeading ||
            (source_ == GuessSource::kOdometry && input.odometry->is_heading_only));
  }

  MotionPriorOptions options_;
  GuessSource source_;
  double heading_sigma_;
  MotionState state_;
};

}  // namespace matchbox_slam
