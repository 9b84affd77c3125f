#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// A recording whose files are open.
struct OpenRecording {
  std::vector<std::unique_ptr<RecordingFile>> files;
  std::vector<std::string> remarks;  ///< of files that are left out, whole sentences
};

/// Opens a recording by what is inside it, whatever its name: a bag of ROS 1; a bag of ROS 2, which
/// may be a folder of several files, those without messages left out; a log of CARMEN, which may be
/// packed by gzip. Throws ConfigurationError for a file that is missing and BagError for one that
/// is empty, damaged or nothing of that, which names what it is where that is known, and what
/// converts it; BagError also for a folder whose files are all empty.
[[nodiscard]] OpenRecording open_recording(const std::string& path);

}  // namespace matchbox_slam
