#include "bag/ros1_message.hpp"

#include <fmt/core.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <boost/make_shared.hpp>
#include <cstdint>

#include "bag/bag_error.hpp"

namespace matchbox_slam {
namespace {

void skip_header(ByteReader& bytes) {
  (void)bytes.take(3, sizeof(std::uint32_t));  // number and stamp
  (void)bytes.array();                         // frame
}

// Messages are taken apart here before roscpp does it, which gets the memory for as many elements
// as a message says it has before it looks whether they are there.

void check_bytes(ByteReader bytes, const sensor_msgs::LaserScan& /*type*/) {
  skip_header(bytes);
  (void)bytes.take(7, sizeof(float));  // angles, times and limits
  (void)bytes.array(sizeof(float));    // ranges
  (void)bytes.array(sizeof(float));    // intensities
}

void check_bytes(ByteReader bytes, const sensor_msgs::MultiEchoLaserScan& /*type*/) {
  skip_header(bytes);
  (void)bytes.take(7, sizeof(float));     // angles, times and limits
  for (int part = 0; part < 2; ++part) {  // ranges, then intensities
    for (auto beams = bytes.number<std::uint32_t>(); beams > 0; --beams) {
      (void)bytes.array(sizeof(float));
    }
  }
}

void check_bytes(ByteReader bytes, const sensor_msgs::PointCloud2& /*type*/) {
  constexpr std::size_t kFieldBytes = 9;  // offset, datatype and count
  skip_header(bytes);
  (void)bytes.take(2, sizeof(std::uint32_t));  // height and width
  for (auto fields = bytes.number<std::uint32_t>(); fields > 0; --fields) {
    (void)bytes.array();  // name
    (void)bytes.take(kFieldBytes);
  }
  (void)bytes.take(1);                         // byte order
  (void)bytes.take(2, sizeof(std::uint32_t));  // point_step and row_step
  (void)bytes.array();                         // data
  (void)bytes.take(1);                         // is_dense
}

void check_bytes(ByteReader bytes, const sensor_msgs::Imu& /*type*/) {
  skip_header(bytes);
  (void)bytes.take(37, sizeof(double));  // orientation, rates, accelerations, their covariances
}

void check_bytes(ByteReader bytes, const nav_msgs::Odometry& /*type*/) {
  skip_header(bytes);
  (void)bytes.array();                   // child frame
  (void)bytes.take(85, sizeof(double));  // pose, velocities, their covariances
}

void check_bytes(ByteReader bytes, const tf2_msgs::TFMessage& /*type*/) {
  for (auto left = bytes.number<std::uint32_t>(); left > 0; --left) {
    skip_header(bytes);
    (void)bytes.array();                  // child frame
    (void)bytes.take(7, sizeof(double));  // translation and rotation
  }
}

/// Reads a message of a topic. Throws BagError when its bytes are none of this type.
template <typename Message>
boost::shared_ptr<const Message> deserialize(ByteReader bytes, const BagConnection& connection) {
  const bool is_told = !connection.md5sum.empty() || connection.type.empty();
  if (is_told && connection.md5sum != ros::message_traits::md5sum<Message>()) {
    throw BagError(
        fmt::format("topic {} of the bag holds {} in a definition that is not the one of {}",
                    connection.topic, connection.type, ros::message_traits::datatype<Message>()));
  }
  auto message = boost::make_shared<Message>();
  check_bytes(bytes, *message);
  // roscpp reads from what it could write to. NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, *message);
  return message;
}

template <typename Message>
bool is_of(const BagConnection& connection) {
  return connection.type == ros::message_traits::datatype<Message>();
}

}  // namespace

MessageContent read_ros1_message(const ByteReader& bytes, const BagConnection& connection) {
  if (is_of<sensor_msgs::LaserScan>(connection)) {
    return deserialize<sensor_msgs::LaserScan>(bytes, connection);
  }
  if (is_of<sensor_msgs::MultiEchoLaserScan>(connection)) {
    return deserialize<sensor_msgs::MultiEchoLaserScan>(bytes, connection);
  }
  if (is_of<sensor_msgs::PointCloud2>(connection)) {
    return deserialize<sensor_msgs::PointCloud2>(bytes, connection);
  }
  if (is_of<sensor_msgs::Imu>(connection)) {
    return deserialize<sensor_msgs::Imu>(bytes, connection);
  }
  if (is_of<nav_msgs::Odometry>(connection)) {
    return deserialize<nav_msgs::Odometry>(bytes, connection);
  }
  // Before tf2 the same had another name; by another definition it is none of these.
  return deserialize<tf2_msgs::TFMessage>(bytes, connection);
}

}  // namespace matchbox_slam
