#pragma once

#include "bag/byte_reader.hpp"
#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// Reads a message as ROS 1 sends it.
/// Throws BagError when its type is none that is read, or is by another definition, and ByteError
/// when its bytes are none of this type.
[[nodiscard]] MessageContent read_ros1_message(const ByteReader& bytes,
                                               const BagConnection& connection);

}  // namespace matchbox_slam
