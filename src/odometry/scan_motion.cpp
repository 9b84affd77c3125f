#include "odometry/scan_motion.hpp"

#include <memory>
#include <utility>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace matchbox_slam {
namespace {

/// [s] in which a robot may begin to turn and end. A guess: half and double were not tried.
constexpr double kMaxSteadyTime = 1.0;

LaserOdometrySettings settings_of(const ProjectionOptions& options) {
  LaserOdometrySettings settings;
  settings.scan = options;
  return settings;
}

}  // namespace

ScanMotion::ScanMotion(const ProjectionOptions& options)
    : odometry_(settings_of(options), std::make_shared<OlsonMatcher>(), GuessSource::kVelocity, 1) {
}

std::optional<Pose2> ScanMotion::add(const ScanInput& input) {
  const double stamp = input.scan.stamp;
  const std::optional<double> last = last_stamp_;
  if (last && stamp <= *last) {
    return std::nullopt;
  }
  last_stamp_ = stamp;
  before_ = std::exchange(newest_, std::nullopt);
  if (last && stamp - *last > kMaxSteadyTime) {
    return std::nullopt;
  }
  ScanInput alone = input;
  alone.odometry.reset();
  const LaserOdometryOutcome outcome = odometry_.process(alone);
  if (last && !outcome.match.accepted()) {
    return std::nullopt;
  }
  newest_ = Stamped{stamp, outcome.odom_from_base};
  return outcome.odom_from_base;
}

std::optional<Pose2> ScanMotion::odom_from_base_at(double stamp) const {
  if (!before_ || !newest_ || stamp < before_->stamp || stamp > newest_->stamp) {
    return std::nullopt;
  }
  return interpolate(before_->odom_from_base, newest_->odom_from_base,
                     (stamp - before_->stamp) / (newest_->stamp - before_->stamp));
}

}  // namespace matchbox_slam
