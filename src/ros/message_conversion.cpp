#include "matchbox_slam/ros/message_conversion.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace matchbox_slam {

namespace {

// Longer than any laser takes for a sweep: then `time_increment` is in another unit or not set.
constexpr double kMaxScanDuration = 10.0;

// ros::Time throws beyond 2^32 s, and so would adding to a stamp that is near it.
constexpr std::uint32_t kLatestSecond = 4'000'000'000U;

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

std::string find_defect(const sensor_msgs::LaserScan& message) {
  if (message.ranges.empty()) {
    return "it has no ranges";
  }
  if (message.header.stamp.isZero() || message.header.stamp.sec > kLatestSecond) {
    return "its stamp " + std::to_string(message.header.stamp.sec) + " s is none";
  }
  if (message.header.frame_id.empty() || message.header.frame_id == "/") {
    return "its frame_id is empty";
  }
  if (!std::isfinite(message.angle_min) || !std::isfinite(message.angle_increment)) {
    return "its angle_min or angle_increment is not a number";
  }
  if (message.angle_increment == 0.0F && message.ranges.size() > 1) {
    return "its angle_increment is 0, so all beams point the same way";
  }
  if (!(message.range_min >= 0.0F) || !(message.range_max > message.range_min)) {
    return "its range_min " + std::to_string(message.range_min) + " and range_max " +
           std::to_string(message.range_max) + " leave no valid range";
  }
  const double duration =
      static_cast<double>(message.time_increment) * static_cast<double>(message.ranges.size() - 1);
  if (!(duration >= 0.0 && duration <= kMaxScanDuration)) {
    return "its time_increment " + std::to_string(message.time_increment) +
           " s makes no sweep of 0 to 10 s";
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
