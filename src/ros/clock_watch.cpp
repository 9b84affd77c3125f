#include "ros/clock_watch.hpp"

#include <cmath>

#include "ros/message_conversion.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {

namespace {

constexpr double kWatchTime = 2.0;  // [s] of scans and transforms
constexpr double kMaxWait = 5.0;    // [s] with scans alone

}  // namespace

void ClockWatch::add_scan(const ros::Time& stamp, const ros::Time& arrival) {
  if (is_watching_ && !arrival.isZero()) {
    first_scan_ = first_scan_ ? first_scan_ : arrival;
    clocks_.add_scan(stamp, arrival);
  }
}

void ClockWatch::add_transforms(const tf2_msgs::TFMessage& message, const ros::Time& arrival) {
  if (!is_watching_ || arrival.isZero()) {
    return;
  }
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (without_leading_slash(transform.header.frame_id) != map_frame_ &&
        without_leading_slash(transform.child_frame_id) != map_frame_) {
      clocks_.add_transform(transform, arrival);
    }
  }
}

std::optional<double> ClockWatch::conclude(const ros::Time& now) {
  if (!is_watching_ || !first_scan_) {
    return std::nullopt;
  }
  const double watched = seconds_between(*first_scan_, now);
  const std::optional<double> offset = clocks_.offset();
  if (watched < kWatchTime || (!offset && watched < kMaxWait)) {
    return std::nullopt;
  }
  is_watching_ = false;
  return offset && std::abs(*offset) > kMinToldClockOffset ? *offset : 0.0;
}

}  // namespace matchbox_slam
