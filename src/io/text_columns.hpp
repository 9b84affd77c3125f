#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// How the lines of a text file hold numbers.
struct TextFormat {
  std::vector<std::string> columns;  ///< their names
  std::string text;                  ///< what follows "has 7 columns" where that is wrong
  char separator = ' ';              ///< of the numbers; a blank is any white space
};

/// Where in which file of text, for errors.
struct TextPlace {
  const std::string& source;
  std::size_t line;

  /// Throws FileError: source, line, and what is wrong there.
  [[noreturn]] void fail(const std::string& text) const;
};

/// Calls `use` with the numbers of each line and its place. Empty lines are passed over, and so is
/// what stands behind a '#'. Throws FileError for a line with other columns, and for what is no
/// finite number, whatever the locale.
/// @param source  names the text in errors, such as the file's path.
void for_each_row(const std::string& text, const std::string& source, const TextFormat& format,
                  const std::function<void(const std::vector<double>&, const TextPlace&)>& use);

/// The poses that `pose_of` makes of the rows. Throws FileError also for two poses of one stamp.
[[nodiscard]] Trajectory read_trajectory(
    const std::string& text, const std::string& source, const TextFormat& format,
    const std::function<StampedPose2(const std::vector<double>&, const TextPlace&)>& pose_of);

/// Whether the first line that holds anything but a comment has a separator in it.
[[nodiscard]] bool has_separator(const std::string& text, char separator);

}  // namespace matchbox_slam
