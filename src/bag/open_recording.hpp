#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// Opens a recording by what is inside it, whatever its name: a bag of ROS 1; a bag of ROS 2, which
/// may be a folder of several files; a log of CARMEN, which may be packed by gzip.
/// Throws ConfigurationError for a file that is missing and BagError for one that is empty, damaged
/// or nothing of that, which names what it is where that is known, and what converts it.
[[nodiscard]] std::vector<std::unique_ptr<RecordingFile>> open_recording(const std::string& path);

}  // namespace matchbox_slam
