#pragma once

#include <string>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// Whether a text is in the format of parse_stata_truth rather than TUM: its first line that holds
/// anything but a comment has a comma.
[[nodiscard]] bool looks_like_stata_truth(const std::string& text);

/// Reads ground truth as the MIT Stata Center data set ships it (`*.gt.laser.poses`; Fallon,
/// Johannsson, Kaess, Leonard, "The MIT Stata Center dataset", 2013): one line a pose,
/// `stamp,x,y,theta`, stamp in whole microseconds, metres, radians; no heading. The poses are those
/// of the laser. Blank lines and comments from '#' on are passed over.
/// @param source  names the text in errors, such as the file's path.
/// Throws FileError with source and line for a line of another form and numbers that are not
/// finite; for two poses of one stamp with source and stamp.
[[nodiscard]] Trajectory parse_stata_truth(const std::string& text, const std::string& source);

}  // namespace matchbox_slam
