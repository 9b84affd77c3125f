#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// A pose as one writes it on a command line: X,Y,THETA in metres and radians. Of the three numbers
/// the first `least` have to be there, the others are 0. None when it is no such pose.
[[nodiscard]] std::optional<Pose2> parse_pose(const std::string& text, std::size_t least);

}  // namespace matchbox_slam
