#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace matchbox_slam {

/// A scan of a square room around the laser, 4 m wide.
inline sensor_msgs::LaserScan make_scan(double stamp, const std::string& frame = "laser",
                                        std::size_t beams = 90) {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = ros::Time(stamp);
  scan.header.frame_id = frame;
  scan.angle_min = -2.0F;
  scan.angle_increment = 4.0F / static_cast<float>(beams);
  scan.range_min = 0.1F;
  scan.range_max = 30.0F;
  for (std::size_t k = 0; k < beams; ++k) {
    const double angle = -2.0 + 4.0 * static_cast<double>(k) / static_cast<double>(beams);
    scan.ranges.push_back(
        static_cast<float>(2.0 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)))));
  }
  return scan;
}

inline geometry_msgs::TransformStamped make_transform(double stamp, const std::string& parent,
                                                      const std::string& child, double x,
                                                      double yaw = 0.0) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = ros::Time(stamp);
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform.translation.x = x;
  transform.transform.rotation.z = std::sin(0.5 * yaw);
  transform.transform.rotation.w = std::cos(0.5 * yaw);
  return transform;
}

inline tf2_msgs::TFMessage make_transforms(
    const std::vector<geometry_msgs::TransformStamped>& transforms) {
  tf2_msgs::TFMessage message;
  message.transforms = transforms;
  return message;
}

/// One link in a message of its own.
inline tf2_msgs::TFMessage make_link(double stamp, const std::string& parent,
                                     const std::string& child, double x, double yaw = 0.0) {
  return make_transforms({make_transform(stamp, parent, child, x, yaw)});
}

/// How `write_small_bag` records.
struct SmallBag {
  double begin = 1000.0;
  int first_scan = 0;  ///< those before are left out
  int scans = 50;
  double scan_period = 0.1;
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  std::string laser_frame = "laser";
  std::string scan_topic = "/scan";
  double transform_delay = 0.0;  ///< [s] from a transform's stamp to its recording
  double scan_clock = 0.0;       ///< [s] added to the stamps of scans
  bool with_transforms = true;
  std::string other_parent;  ///< publishes this frame above `odom_frame` too
  rosbag::CompressionType compression = rosbag::compression::Uncompressed;
};

inline tf2_msgs::TFMessage make_robot_transforms(double stamp, const SmallBag& recipe) {
  tf2_msgs::TFMessage message = make_transforms(
      {make_transform(stamp, recipe.odom_frame, recipe.base_frame, 0.02 * (stamp - recipe.begin)),
       make_transform(stamp, recipe.base_frame, recipe.laser_frame, 0.2)});
  if (!recipe.other_parent.empty()) {
    message.transforms.push_back(
        make_transform(stamp, recipe.other_parent, recipe.odom_frame, 1.0));
  }
  return message;
}

/// A robot at rest in a room for some seconds whose odometry, at 20 Hz, creeps ahead.
inline void write_small_bag(const std::string& path, const SmallBag& recipe = {}) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  bag.setCompression(recipe.compression);
  const double end = recipe.begin + recipe.scan_period * recipe.scans;
  int scan = 0;
  const auto write_scans_until = [&](double time) {
    for (; scan < recipe.scans && recipe.begin + recipe.scan_period * scan < time; ++scan) {
      const double stamp = recipe.begin + recipe.scan_period * scan;
      if (scan >= recipe.first_scan) {
        bag.write(recipe.scan_topic, ros::Time(stamp),
                  make_scan(stamp + recipe.scan_clock, recipe.laser_frame));
      }
    }
  };
  for (int k = -2; recipe.with_transforms && recipe.begin + 0.05 * k < end + 0.2; ++k) {
    const double stamp = recipe.begin + 0.05 * k;
    write_scans_until(stamp + recipe.transform_delay);
    bag.write("/tf", ros::Time(stamp + recipe.transform_delay),
              make_robot_transforms(stamp, recipe));
  }
  write_scans_until(end + 1.0);
  bag.close();
}

}  // namespace matchbox_slam
