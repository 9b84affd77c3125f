#pragma once

#include <cstddef>
#include <string>

#include "geometry/trajectory.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

/// Reads a trajectory in the TUM format: one line a pose, `stamp x y z qx qy qz qw`, in seconds and
/// metres; lines may come in any order, be empty, or be comments from '#' on. Of a pose in space
/// the position in the x-y plane and the yaw are kept. A text without poses is an empty trajectory.
/// @param source  names the text in errors, such as the file's path.
/// Throws FileError with source and line for a line of another form, numbers that are not finite,
/// and quaternions that are no rotation; for two poses of one stamp with source and stamp.
[[nodiscard]] Trajectory parse_tum(const std::string& text, const std::string& source);

/// Reads a file; throws FileError also when that is not possible.
[[nodiscard]] Trajectory read_tum(const std::string& path);

/// The trajectory in the TUM format: z is 0, the quaternion a yaw; stamps with 6 decimals, all else
/// with 9. The same poses give the same bytes, whatever the locale.
[[nodiscard]] std::string to_tum(const Trajectory& trajectory);

/// The same, a page at a time.
void write_tum(const Trajectory& trajectory, const ByteSink& sink);

/// Where the poses of a drive go whose clock has stepped back: those of before the first step to
/// "drive.1.tum" and so on, those since the last step to `path` itself, as of "drive.tum".
[[nodiscard]] std::string path_of_part(const std::string& path, std::size_t part,
                                       std::size_t parts);

/// Adds a file for each of these parts. @param comment  first line of each; empty: none.
void add_tum_parts(const std::string& path, const std::vector<std::vector<StampedPose2>>& parts,
                   const std::string& comment, FileReplacement& files);

/// Writes a file atomically. Throws FileError.
void write_tum(const std::string& path, const Trajectory& trajectory);

}  // namespace matchbox_slam
