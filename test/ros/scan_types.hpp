#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace matchbox_slam {

/// The same scan as a laser of several echoes tells it; the second ones are farther away.
inline sensor_msgs::MultiEchoLaserScan to_multi_echo(const sensor_msgs::LaserScan& scan) {
  sensor_msgs::MultiEchoLaserScan message;
  message.header = scan.header;
  message.angle_min = scan.angle_min;
  message.angle_max = scan.angle_max;
  message.angle_increment = scan.angle_increment;
  message.time_increment = scan.time_increment;
  message.scan_time = scan.scan_time;
  message.range_min = scan.range_min;
  message.range_max = scan.range_max;
  message.ranges.resize(scan.ranges.size());
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    message.ranges[k].echoes.push_back(scan.ranges[k]);
    if (k % 3 == 0) {
      message.ranges[k].echoes.push_back(scan.ranges[k] + 1.0F);
    }
  }
  return message;
}

/// A point of a cloud as most drivers send it.
struct CloudPoint {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  std::uint16_t ring = 0;
};

inline void add_field(sensor_msgs::PointCloud2& cloud, const std::string& name,
                      std::uint32_t offset, std::uint8_t datatype) {
  cloud.fields.emplace_back();
  cloud.fields.back().name = name;
  cloud.fields.back().offset = offset;
  cloud.fields.back().datatype = datatype;
  cloud.fields.back().count = 1;
}

/// With fields x, y and z at 0, 4 and 8, as of PCL a gap, and ring at 20, in rows of `width`.
inline sensor_msgs::PointCloud2 make_cloud(const std_msgs::Header& header,
                                           const std::vector<CloudPoint>& points,
                                           std::uint32_t height = 1) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = header;
  cloud.height = height;
  cloud.width = static_cast<std::uint32_t>(points.size()) / height;
  add_field(cloud, "x", 0, sensor_msgs::PointField::FLOAT32);
  add_field(cloud, "y", 4, sensor_msgs::PointField::FLOAT32);
  add_field(cloud, "z", 8, sensor_msgs::PointField::FLOAT32);
  add_field(cloud, "ring", 20, sensor_msgs::PointField::UINT16);
  cloud.point_step = 24;
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(points.size() * cloud.point_step);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint8_t* const point = cloud.data.data() + i * cloud.point_step;
    std::memcpy(point, &points[i].x, sizeof(float));
    std::memcpy(point + 4, &points[i].y, sizeof(float));
    std::memcpy(point + 8, &points[i].z, sizeof(float));
    std::memcpy(point + 20, &points[i].ring, sizeof(std::uint16_t));
  }
  return cloud;
}

/// The ends of a scan's beams among points of other heights and rings.
inline sensor_msgs::PointCloud2 to_cloud(const sensor_msgs::LaserScan& scan) {
  std::vector<CloudPoint> points;
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const auto range = static_cast<double>(scan.ranges[k]);
    if (!(range >= static_cast<double>(scan.range_min) &&
          range < static_cast<double>(scan.range_max))) {
      points.push_back({NAN, NAN, NAN, 3});
      continue;
    }
    const double angle = static_cast<double>(scan.angle_min) +
                         static_cast<double>(k) * static_cast<double>(scan.angle_increment);
    const auto x = static_cast<float>(range * std::cos(angle));
    const auto y = static_cast<float>(range * std::sin(angle));
    points.push_back({x, y, 0.0F, 3});
    points.push_back({0.5F * x, 0.5F * y, -0.5F, 2});
    points.push_back({0.5F * x, 0.5F * y, 0.5F, 4});
  }
  return make_cloud(scan.header, points);
}

/// A copy of a bag with the scans of one topic, and of no other, as `convert` makes them.
template <typename Convert>
void convert_bag(const std::string& from, const std::string& to, const std::string& topic,
                 const std::string& new_topic, const Convert& convert) {
  rosbag::Bag in(from, rosbag::bagmode::Read);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    const auto scan = message.instantiate<sensor_msgs::LaserScan>();
    if (scan == nullptr) {
      out.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
    } else if (message.getTopic() == topic) {
      out.write(new_topic, message.getTime(), convert(*scan));
    }
  }
  out.close();
}

}  // namespace matchbox_slam
