#pragma once

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// Writes plain CDR, version 1, as ROS 2 does, in either byte order.
class CdrWriter {
 public:
  explicit CdrWriter(bool is_little_endian = true) : is_little_endian_(is_little_endian) {
    bytes_ = {'\0', is_little_endian ? '\1' : '\0', '\0', '\0'};
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

  template <typename Number>
  void number(Number value) {
    while ((bytes_.size() - 4) % sizeof(Number) != 0) {
      bytes_ += '\0';
    }
    std::string raw(sizeof(Number), '\0');
    std::memcpy(raw.data(), &value, sizeof(Number));
    if (!is_little_endian_) {
      std::reverse(raw.begin(), raw.end());
    }
    bytes_ += raw;
  }

  void count(std::size_t value) { number(static_cast<std::uint32_t>(value)); }

  void text(const std::string& text) {
    count(text.size() + 1);
    bytes_ += text + '\0';
  }

  template <typename Numbers>
  void numbers(const Numbers& values) {
    for (const auto value : values) {
      number(value);
    }
  }

  template <typename Numbers>
  void sequence(const Numbers& values) {
    count(values.size());
    numbers(values);
  }

 private:
  std::string bytes_;
  bool is_little_endian_;
};

inline void write(CdrWriter& cdr, const std_msgs::Header& header) {
  cdr.number(static_cast<std::int32_t>(header.stamp.sec));
  cdr.number(header.stamp.nsec);
  cdr.text(header.frame_id);
}

template <typename Vector>
void write_vector(CdrWriter& cdr, const Vector& vector) {
  cdr.number(vector.x);
  cdr.number(vector.y);
  cdr.number(vector.z);
}

inline void write(CdrWriter& cdr, const geometry_msgs::Quaternion& rotation) {
  write_vector(cdr, rotation);
  cdr.number(rotation.w);
}

template <typename Scan>
void write_scan_head(CdrWriter& cdr, const Scan& scan) {
  write(cdr, scan.header);
  for (const float value : {scan.angle_min, scan.angle_max, scan.angle_increment,
                            scan.time_increment, scan.scan_time, scan.range_min, scan.range_max}) {
    cdr.number(value);
  }
}

inline void write(CdrWriter& cdr, const sensor_msgs::LaserScan& scan) {
  write_scan_head(cdr, scan);
  cdr.sequence(scan.ranges);
  cdr.sequence(scan.intensities);
}

inline void write(CdrWriter& cdr, const sensor_msgs::MultiEchoLaserScan& scan) {
  write_scan_head(cdr, scan);
  for (const auto* beams : {&scan.ranges, &scan.intensities}) {
    cdr.count(beams->size());
    for (const sensor_msgs::LaserEcho& beam : *beams) {
      cdr.sequence(beam.echoes);
    }
  }
}

inline void write(CdrWriter& cdr, const sensor_msgs::PointCloud2& cloud) {
  write(cdr, cloud.header);
  cdr.number(cloud.height);
  cdr.number(cloud.width);
  cdr.count(cloud.fields.size());
  for (const sensor_msgs::PointField& field : cloud.fields) {
    cdr.text(field.name);
    cdr.number(field.offset);
    cdr.number(field.datatype);
    cdr.number(field.count);
  }
  cdr.number(cloud.is_bigendian);
  cdr.number(cloud.point_step);
  cdr.number(cloud.row_step);
  cdr.sequence(cloud.data);
  cdr.number(cloud.is_dense);
}

inline void write(CdrWriter& cdr, const tf2_msgs::TFMessage& message) {
  cdr.count(message.transforms.size());
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    write(cdr, transform.header);
    cdr.text(transform.child_frame_id);
    write_vector(cdr, transform.transform.translation);
    write(cdr, transform.transform.rotation);
  }
}

inline void write(CdrWriter& cdr, const sensor_msgs::Imu& imu) {
  write(cdr, imu.header);
  write(cdr, imu.orientation);
  cdr.numbers(imu.orientation_covariance);
  write_vector(cdr, imu.angular_velocity);
  cdr.numbers(imu.angular_velocity_covariance);
  write_vector(cdr, imu.linear_acceleration);
  cdr.numbers(imu.linear_acceleration_covariance);
}

inline void write(CdrWriter& cdr, const nav_msgs::Odometry& odometry) {
  write(cdr, odometry.header);
  cdr.text(odometry.child_frame_id);
  write_vector(cdr, odometry.pose.pose.position);
  write(cdr, odometry.pose.pose.orientation);
  cdr.numbers(odometry.pose.covariance);
  write_vector(cdr, odometry.twist.twist.linear);
  write_vector(cdr, odometry.twist.twist.angular);
  cdr.numbers(odometry.twist.covariance);
}

/// A message as ROS 2 sends it.
[[nodiscard]] inline std::string to_cdr(const MessageContent& content,
                                        bool is_little_endian = true) {
  CdrWriter cdr(is_little_endian);
  std::visit([&cdr](const auto& message) { write(cdr, *message); }, content);
  return cdr.bytes();
}

/// The name of its type in ROS 2.
[[nodiscard]] inline std::string ros2_type(std::string ros1_type) {
  return ros1_type.replace(ros1_type.find('/'), 1, "/msg/");
}

}  // namespace matchbox_slam
