#include "bag/open_recording.hpp"

#include "bag/ros1_bag.hpp"

namespace matchbox_slam {

std::vector<std::unique_ptr<RecordingFile>> open_recording(const std::string& path) {
  std::vector<std::unique_ptr<RecordingFile>> files;
  files.push_back(std::make_unique<Ros1Bag>(path));
  return files;
}

}  // namespace matchbox_slam
