#pragma once

#include <string>
#include <vector>

namespace matchbox_slam {

/// The files of a bag of ROS 2, which is a folder: those that its metadata.yaml names, in that
/// order, else all that end in .db3 or .mcap, by their names. None: the folder is no such bag.
/// Throws BagError where one that is named is not there, or the metadata cannot be read.
[[nodiscard]] std::vector<std::string> files_of_ros2_folder(const std::string& folder);

}  // namespace matchbox_slam
