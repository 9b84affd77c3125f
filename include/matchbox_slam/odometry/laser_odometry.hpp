#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/motion/motion_prior.hpp"
#include "matchbox_slam/motion/motion_state.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/engine_options.hpp"

namespace matchbox_slam {

struct LaserOdometryOptions {
  double key_distance = 0.3;
  double key_angle = 0.2;
  double key_overlap = 0.5;
  int local_map_scans = 20;
  int min_points = 10;
  int lost_after = 10;
  double heading_floor = 0.005;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(
        self.key_distance, "key_distance", between(0.01, 100.0), "m",
        "A scan becomes a key scan when every key scan of the local map is at least this far away "
        "or turned by key_angle.");
    option(
        self.key_angle, "key_angle", between(0.01, 3.2), "rad",
        "A scan becomes a key scan when every key scan of the local map is turned by at least this "
        "or key_distance away.");
    option(
        self.key_overlap, "key_overlap", between(0.0, 1.0), "",
        "A third of key_distance and key_angle is enough when less than this share of the scan has "
        "the local map near; 0: never.");
    option(self.local_map_scans, "local_map_scans", between(1, 200), "",
           "The local map is made of the last so many key scans, or up to twice as many.");
    option(self.min_points, "min_points", between(1, 100000), "",
           "Scans with fewer hits are not matched; the guess stands.");
    option(self.lost_after, "lost_after", between(1, 100000), "",
           "After so many scans in a row that do not fit, a new local map starts where the guess "
           "is, and without guess the base counts as at rest.");
    option(self.heading_floor, "heading_floor", between(1e-6, 1.0), "rad",
           "Standard deviation of a turn from scan to scan by a heading that is measured, as an "
           "IMU does.");
  }
};

/// All options of laser odometry, a section each: `odometry/`, and as in the SLAM engine `scan/`,
/// `map/`, `field/` and `motion/`.
struct LaserOdometrySettings {
  LaserOdometryOptions odometry;
  ProjectionOptions scan;
  MapOptions map;
  LikelihoodFieldOptions field;
  MotionPriorOptions motion;
};

/// Reads the sections from `parameters`; other keys are left to their owners. The engine's section
/// `slam` is checked and has no effect, so that one file serves both.
/// Throws ConfigurationError for unknown keys within the sections and for bad values.
[[nodiscard]] LaserOdometrySettings read_laser_odometry_settings(const Parameters& parameters);

/// What became of one scan.
struct LaserOdometryOutcome {
  double stamp = 0.0;                                    ///< [s]
  Pose2 odom_from_base;                                  ///< at the scan's stamp; see
                                                         ///< without_overshoot
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< over (x, y, theta) in the odom frame;
                                                         ///< grows with the way, and shrinks a
                                                         ///< little where it comes back
  /// In the base frame: (x [m/s], y [m/s], theta [rad/s]), the mean since the last scan that was
  /// matched; if this one was not, that of the guess.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();
  Pose2 guessed_odom_from_base;
  MatchResult match;  ///< status kRejectedNoReference for a scan that starts a local map
  bool is_key_scan = false;
  bool restarted = false;  ///< too many scans did not fit: a new local map starts with this one
};

/// Variance of what nothing is known about: [m^2], [rad^2], or of a velocity.
constexpr double kUnknownVariance = 1e6;

/// Odometry from scans by any matcher, without a map of the whole: each scan is matched against a
/// local map of the last key scans, which is dropped as the robot moves on, so that memory stays
/// bounded and the pose never jumps. Two such maps overlap (as the submaps of Hess et al.,
/// "Real-Time Loop Closure in 2D LIDAR SLAM", ICRA 2016): the newer one takes over when it is full.
/// Nothing is added at rest, so that the pose does not drift there.
///
/// Single-threaded; the same scans, options and seed yield the same bits.
class LaserOdometry {
 public:
  /// @param matcher  configured; shared, since it has no state.
  LaserOdometry(const LaserOdometrySettings& settings, std::shared_ptr<const ScanMatcher> matcher,
                GuessSource guess, std::uint64_t seed);
  LaserOdometry(LaserOdometry&& other) noexcept;
  LaserOdometry& operator=(LaserOdometry&& other) noexcept;
  ~LaserOdometry();

  /// Processes the next scan; the first one is the origin. Throws as MotionTracker::predict; then
  /// nothing has changed.
  LaserOdometryOutcome process(const ScanInput& input);

  /// Key scans that the next scan is matched against, oldest first.
  [[nodiscard]] const PlacedScans& key_scans() const;

  /// Memory of both local maps and of the covariances, without the key scans.
  [[nodiscard]] std::size_t bytes() const;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace matchbox_slam
