#include "ros/message_conversion.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "matchbox_slam/matching/scan_matcher.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {

namespace {

// Longer than any laser takes for a sweep: then `time_increment` is in another unit or not set.
constexpr double kMaxScanDuration = 10.0;

// ros::Time throws beyond 2^32 s, and so would adding to a stamp that is near it.
constexpr std::uint32_t kLatestSecond = 4'000'000'000U;

constexpr std::int64_t kNanosecondsInSecond = 1'000'000'000;

// No laser has a tenth of these; a scan of millions would stop the mapping for minutes.
constexpr std::size_t kMostReadings = 100'000;

// A coordinate in any frame; once around the Earth is less.
constexpr double kFarthest = 1e8;  // m

constexpr std::array<std::size_t, 3> kPlaneAxes = {0, 1, 5};  // x, y and yaw among six

std::int8_t to_percent(const OccupancyGrid& grid, const Cell& cell) {
  return grid.is_known(cell) ? static_cast<std::int8_t>(std::lround(100.0 * grid.occupancy(cell)))
                             : std::int8_t{-1};
}

geometry_msgs::Quaternion to_quaternion(double theta) {
  geometry_msgs::Quaternion q;
  q.z = std::sin(0.5 * theta);
  q.w = std::cos(0.5 * theta);
  return q;
}

}  // namespace

double seconds_between(const ros::Time& begin, const ros::Time& end) {
  const auto nanoseconds =
      static_cast<std::int64_t>(end.toNSec()) - static_cast<std::int64_t>(begin.toNSec());
  std::int64_t whole = nanoseconds / kNanosecondsInSecond;
  std::int64_t rest = nanoseconds % kNanosecondsInSecond;
  if (rest < 0) {  // as ros::Duration has it
    --whole;
    rest += kNanosecondsInSecond;
  }
  return static_cast<double>(whole) + 1e-9 * static_cast<double>(rest);
}

bool is_usable(const ros::Time& stamp) {
  return stamp.sec <= kLatestSecond && stamp.nsec < kNanosecondsInSecond;
}

bool is_usable(const geometry_msgs::Vector3& position) {
  return std::abs(position.x) <= kFarthest && std::abs(position.y) <= kFarthest &&
         std::abs(position.z) <= kFarthest;
}

bool is_rotation(const geometry_msgs::Quaternion& q) {
  constexpr double kNormTolerance = 0.05;
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return std::abs(norm - 1.0) <= kNormTolerance;  // nan is not
}

std::string find_defect(const geometry_msgs::PoseWithCovariance& message) {
  geometry_msgs::Vector3 position;
  position.x = message.pose.position.x;
  position.y = message.pose.position.y;
  if (!is_usable(position)) {
    return "its position is no number of metres, or farther than around the Earth";
  }
  if (!is_rotation(message.pose.orientation)) {
    return "its orientation is no quaternion of length 1";
  }
  const Eigen::Matrix3d covariance = plane_covariance(message);
  if (!is_covariance(covariance) || covariance.maxCoeff() > kFarthest * kFarthest) {
    return "its covariance is none: it has to be of numbers, symmetric, and without negative "
           "variance in any direction";
  }
  return {};
}

std::string find_defect(const sensor_msgs::LaserScan& message) {
  if (message.ranges.empty()) {
    return "it has no ranges";
  }
  if (message.ranges.size() > kMostReadings) {
    return fmt::format("it has {} ranges; allowed: up to {}", message.ranges.size(), kMostReadings);
  }
  if (message.header.stamp.isZero() || !is_usable(message.header.stamp)) {
    return fmt::format("its stamp {} s {} ns is none", message.header.stamp.sec,
                       message.header.stamp.nsec);
  }
  if (!is_frame_id(without_leading_slash(message.header.frame_id))) {
    return fmt::format("its frame_id '{}' is none", message.header.frame_id);
  }
  if (!std::isfinite(message.angle_min) || !std::isfinite(message.angle_increment)) {
    return "its angle_min or angle_increment is not a number";
  }
  if (message.angle_increment == 0.0F && message.ranges.size() > 1) {
    return "its angle_increment is 0, so all beams point the same way";
  }
  if (!(message.range_min >= 0.0F) || !(message.range_max > message.range_min)) {
    return fmt::format("its range_min {:f} and range_max {:f} leave no valid range",
                       message.range_min, message.range_max);
  }
  const double duration =
      static_cast<double>(message.time_increment) * static_cast<double>(message.ranges.size() - 1);
  if (!(duration >= 0.0 && duration <= kMaxScanDuration)) {
    return fmt::format("its time_increment {:f} s makes no sweep of 0 to 10 s",
                       message.time_increment);
  }
  return {};
}

LaserScan to_laser_scan(const sensor_msgs::LaserScan& message) {
  LaserScan scan;
  scan.stamp = message.header.stamp.toSec();
  scan.angle_min = static_cast<double>(message.angle_min);
  scan.angle_increment = static_cast<double>(message.angle_increment);
  scan.time_increment = static_cast<double>(message.time_increment);
  scan.range_min = static_cast<double>(message.range_min);
  scan.range_max = static_cast<double>(message.range_max);
  scan.ranges = message.ranges;
  return scan;
}

nav_msgs::OccupancyGrid to_message(const OccupancyGrid& grid, const std::string& map_frame,
                                   const ros::Time& stamp) {
  const CellBox box = grid.known_bounds();
  nav_msgs::OccupancyGrid message;
  message.header.stamp = stamp;
  message.header.frame_id = map_frame;
  message.info.map_load_time = stamp;
  message.info.resolution = static_cast<float>(grid.geometry().resolution());
  message.info.origin.orientation.w = 1.0;
  if (box.empty()) {
    return message;
  }
  message.info.width = static_cast<std::uint32_t>(box.width());
  message.info.height = static_cast<std::uint32_t>(box.height());
  const Eigen::Vector2d corner = grid.geometry().corner(box.min);
  message.info.origin.position.x = corner.x();
  message.info.origin.position.y = corner.y();
  message.data.reserve(static_cast<std::size_t>(box.width()) *
                       static_cast<std::size_t>(box.height()));
  for (int y = box.min.y; y < box.max.y; ++y) {
    for (int x = box.min.x; x < box.max.x; ++x) {
      message.data.push_back(to_percent(grid, {x, y}));
    }
  }
  return message;
}

geometry_msgs::Pose to_pose_message(const Pose2& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation = to_quaternion(pose.theta);
  return message;
}

geometry_msgs::Transform to_transform_message(const Pose2& pose) {
  geometry_msgs::Transform message;
  message.translation.x = pose.x;
  message.translation.y = pose.y;
  message.rotation = to_quaternion(pose.theta);
  return message;
}

geometry_msgs::PoseWithCovariance to_pose_message(const Pose2& pose,
                                                  const Eigen::Matrix3d& covariance) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = to_pose_message(pose);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      message.covariance[6 * kPlaneAxes[row] + kPlaneAxes[column]] =
          covariance(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
    }
  }
  return message;
}

Pose2 to_pose2(const geometry_msgs::Pose& pose) {
  const geometry_msgs::Quaternion& q = pose.orientation;
  const double theta =
      std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
  return {pose.position.x, pose.position.y, wrap_angle(theta)};
}

Eigen::Matrix3d plane_covariance(const geometry_msgs::PoseWithCovariance& pose) {
  Eigen::Matrix3d covariance;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      covariance(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
          pose.covariance[6 * kPlaneAxes[row] + kPlaneAxes[column]];
    }
  }
  return covariance;
}

}  // namespace matchbox_slam
