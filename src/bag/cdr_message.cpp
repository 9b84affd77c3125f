#include "bag/cdr_message.hpp"

#include <fmt/core.h>
#include <ros/message_traits.h>

#include <boost/make_shared.hpp>
#include <cstddef>
#include <cstdint>

#include "bag/bag_error.hpp"
#include "bag/cdr_reader.hpp"
#include "bag/unpacking.hpp"

namespace matchbox_slam {
namespace {

// Fields in the order of the definitions of ROS 2, which are those of ROS 1 but for the header,
// which has no number.

ros::Time read_stamp(CdrReader& bytes) {
  constexpr std::uint32_t kNanoseconds = 1'000'000'000U;
  const auto seconds = bytes.number<std::int32_t>();
  const auto nanoseconds = bytes.number<std::uint32_t>();
  if (seconds < 0 || nanoseconds >= kNanoseconds) {
    throw ByteError(fmt::format("a stamp is {} s and {} ns", seconds, nanoseconds));
  }
  return {static_cast<std::uint32_t>(seconds), nanoseconds};
}

void read(CdrReader& bytes, std_msgs::Header& header) {
  header.stamp = read_stamp(bytes);
  header.frame_id = bytes.text();
}

template <typename Vector>
void read_vector(CdrReader& bytes, Vector& vector) {
  vector.x = bytes.number<double>();
  vector.y = bytes.number<double>();
  vector.z = bytes.number<double>();
}

void read(CdrReader& bytes, geometry_msgs::Quaternion& rotation) {
  read_vector(bytes, rotation);
  rotation.w = bytes.number<double>();
}

template <typename Scan>
void read_scan_head(CdrReader& bytes, Scan& scan) {
  read(bytes, scan.header);
  scan.angle_min = bytes.number<float>();
  scan.angle_max = bytes.number<float>();
  scan.angle_increment = bytes.number<float>();
  scan.time_increment = bytes.number<float>();
  scan.scan_time = bytes.number<float>();
  scan.range_min = bytes.number<float>();
  scan.range_max = bytes.number<float>();
}

void read(CdrReader& bytes, sensor_msgs::LaserScan& scan) {
  read_scan_head(bytes, scan);
  bytes.sequence(scan.ranges);
  bytes.sequence(scan.intensities);
}

void read(CdrReader& bytes, sensor_msgs::MultiEchoLaserScan& scan) {
  read_scan_head(bytes, scan);
  for (auto* beams : {&scan.ranges, &scan.intensities}) {
    beams->resize(bytes.count(sizeof(std::uint32_t)));
    for (sensor_msgs::LaserEcho& beam : *beams) {
      bytes.sequence(beam.echoes);
    }
  }
}

void read(CdrReader& bytes, sensor_msgs::PointCloud2& cloud) {
  constexpr std::size_t kLeastFieldBytes = 13;  // a name's length, offset, datatype and count
  read(bytes, cloud.header);
  cloud.height = bytes.number<std::uint32_t>();
  cloud.width = bytes.number<std::uint32_t>();
  cloud.fields.resize(bytes.count(kLeastFieldBytes));
  for (sensor_msgs::PointField& field : cloud.fields) {
    field.name = bytes.text();
    field.offset = bytes.number<std::uint32_t>();
    field.datatype = bytes.number<std::uint8_t>();
    field.count = bytes.number<std::uint32_t>();
  }
  cloud.is_bigendian = bytes.boolean() ? 1 : 0;
  cloud.point_step = bytes.number<std::uint32_t>();
  cloud.row_step = bytes.number<std::uint32_t>();
  bytes.sequence(cloud.data);
  cloud.is_dense = bytes.boolean() ? 1 : 0;
}

void read(CdrReader& bytes, tf2_msgs::TFMessage& message) {
  constexpr std::size_t kLeastTransformBytes = 16 + 7 * sizeof(double);
  message.transforms.resize(bytes.count(kLeastTransformBytes));
  for (geometry_msgs::TransformStamped& transform : message.transforms) {
    read(bytes, transform.header);
    transform.child_frame_id = bytes.text();
    read_vector(bytes, transform.transform.translation);
    read(bytes, transform.transform.rotation);
  }
}

void read(CdrReader& bytes, sensor_msgs::Imu& imu) {
  read(bytes, imu.header);
  read(bytes, imu.orientation);
  bytes.fixed_array(imu.orientation_covariance);
  read_vector(bytes, imu.angular_velocity);
  bytes.fixed_array(imu.angular_velocity_covariance);
  read_vector(bytes, imu.linear_acceleration);
  bytes.fixed_array(imu.linear_acceleration_covariance);
}

void read(CdrReader& bytes, nav_msgs::Odometry& odometry) {
  read(bytes, odometry.header);
  odometry.child_frame_id = bytes.text();
  read_vector(bytes, odometry.pose.pose.position);
  read(bytes, odometry.pose.pose.orientation);
  bytes.fixed_array(odometry.pose.covariance);
  read_vector(bytes, odometry.twist.twist.linear);
  read_vector(bytes, odometry.twist.twist.angular);
  bytes.fixed_array(odometry.twist.covariance);
}

template <typename Message>
bool is_of(const BagConnection& connection) {
  return connection.type == ros::message_traits::datatype<Message>();
}

template <typename Message>
boost::shared_ptr<const Message> read_whole(const ByteReader& bytes) {
  auto message = boost::make_shared<Message>();
  CdrReader reader(bytes);
  read(reader, *message);
  return message;
}

MessageContent read_unpacked(const ByteReader& bytes, const BagConnection& connection) {
  if (is_of<sensor_msgs::LaserScan>(connection)) {
    return read_whole<sensor_msgs::LaserScan>(bytes);
  }
  if (is_of<sensor_msgs::MultiEchoLaserScan>(connection)) {
    return read_whole<sensor_msgs::MultiEchoLaserScan>(bytes);
  }
  if (is_of<sensor_msgs::PointCloud2>(connection)) {
    return read_whole<sensor_msgs::PointCloud2>(bytes);
  }
  if (is_of<tf2_msgs::TFMessage>(connection)) {
    return read_whole<tf2_msgs::TFMessage>(bytes);
  }
  if (is_of<sensor_msgs::Imu>(connection)) {
    return read_whole<sensor_msgs::Imu>(bytes);
  }
  if (is_of<nav_msgs::Odometry>(connection)) {
    return read_whole<nav_msgs::Odometry>(bytes);
  }
  throw BagError(fmt::format("topic {} of the bag holds {}, which is not read", connection.topic,
                             connection.type));
}

}  // namespace

std::string ros1_type(const std::string& ros2_type) {
  constexpr const char* kMiddle = "/msg/";
  const std::size_t at = ros2_type.find(kMiddle);
  return at == std::string::npos
             ? ros2_type
             : fmt::format("{}/{}", ros2_type.substr(0, at), ros2_type.substr(at + 5));
}

MessageContent read_cdr_message(const ByteReader& bytes, const BagConnection& connection) {
  constexpr std::size_t kLargestMessage = std::size_t{1} << 30U;
  if (is_zstd(bytes)) {  // which no message in CDR begins with
    const Unpacked unpacked = unpack_zstd(bytes, kLargestMessage);
    if (!unpacked.defect.empty()) {
      throw ByteError("it cannot be unpacked: " + unpacked.defect);
    }
    return read_unpacked({unpacked.bytes.data(), unpacked.bytes.size()}, connection);
  }
  return read_unpacked(bytes, connection);
}

}  // namespace matchbox_slam
