#pragma once

#include <string>

namespace matchbox_slam {

/// Whether a file that is there begins as bags do, of ROS 1 or ROS 2, whatever its name.
[[nodiscard]] bool is_bag(const std::string& path);

}  // namespace matchbox_slam
