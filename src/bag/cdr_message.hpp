#pragma once

#include <string>

#include "bag/byte_reader.hpp"
#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// The name in ROS 1 of a type of ROS 2: "sensor_msgs/LaserScan" of "sensor_msgs/msg/LaserScan".
[[nodiscard]] std::string ros1_type(const std::string& ros2_type);

/// Reads a message as ROS 2 records it, packed by zstd or not, whatever file it is in. Throws
/// BagError when its type is none that is read and ByteError when its bytes are none of this type.
[[nodiscard]] MessageContent read_cdr_message(const ByteReader& bytes,
                                              const BagConnection& connection);

}  // namespace matchbox_slam
