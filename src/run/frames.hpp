#pragma once

#include <string>

#include "run/run_options.hpp"

namespace matchbox_slam {

/// The frame id as tf2 wants it: without the one leading slash that recordings before 2013 have.
[[nodiscard]] std::string without_leading_slash(const std::string& frame);

/// Throws ConfigurationError when two of the frames in use are the same. Empty ones are not chosen
/// yet.
void check_frames(const RunOptions& options);

/// What to tell people when the odometry frame hangs below the base frame.
[[nodiscard]] std::string text_of_swapped_frames(const std::string& base_frame,
                                                 const std::string& odom_frame);

}  // namespace matchbox_slam
