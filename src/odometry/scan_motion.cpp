#include "odometry/scan_motion.hpp"

#include <memory>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace matchbox_slam {
namespace {

constexpr double kSteady = 1.0;  // [s], in which a robot may begin to turn and end

}  // namespace

ScanMotion::ScanMotion()
    : odometry_({}, std::make_shared<OlsonMatcher>(OlsonOptions{}), GuessSource::kVelocity, 1) {}

std::optional<Pose2> ScanMotion::add(const ScanInput& input) {
  if (newest_ && input.scan.stamp <= newest_->stamp) {
    return std::nullopt;
  }
  const Pose2 odom_from_base = odometry_.process(input).odom_from_base;
  before_ = newest_;
  newest_ = Stamped{input.scan.stamp, odom_from_base};
  return odom_from_base;
}

std::optional<Pose2> ScanMotion::odom_from_base_at(double stamp) const {
  if (!before_ || stamp < before_->stamp || stamp > newest_->stamp ||
      newest_->stamp - before_->stamp > kSteady) {
    return std::nullopt;
  }
  return interpolate(before_->odom_from_base, newest_->odom_from_base,
                     (stamp - before_->stamp) / (newest_->stamp - before_->stamp));
}

}  // namespace matchbox_slam
