#include "bag/open_recording.hpp"

#include <filesystem>
#include <fstream>

#include "bag/bag_error.hpp"
#include "bag/carmen_log.hpp"
#include "bag/db3_file.hpp"
#include "bag/mcap_file.hpp"
#include "bag/recording_kind.hpp"
#include "bag/ros1_bag.hpp"
#include "bag/ros2_folder.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;
using Format = RecordingKind::Format;

/// Whether there are bytes to look at; what is wrong else, a bag of ROS 1 tells.
bool has_bytes(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && fs::file_size(path, error) > 0 &&
         std::ifstream(path).good();
}

std::unique_ptr<RecordingFile> open_file(const std::string& path) {
  const RecordingKind kind =
      has_bytes(path) ? recording_kind(path) : RecordingKind{Format::kRos1Bag, {}};
  switch (kind.format) {
    case Format::kRos1Bag:
      return std::make_unique<Ros1Bag>(path);
    case Format::kCarmenLog:
      return std::make_unique<CarmenLog>(path);
    case Format::kSqlite:
      return std::make_unique<Db3File>(path);
    case Format::kMcap:
      return std::make_unique<McapFile>(path);
    default:
      throw BagError("'" + path + "' " +
                     (kind.what_to_do.empty()
                          ? "is no bag of version 2.0, no bag of ROS 2 (.db3, .mcap) and no log of "
                            "CARMEN by what is inside it, whatever its name"
                          : kind.what_to_do));
  }
}

}  // namespace

std::vector<std::unique_ptr<RecordingFile>> open_recording(const std::string& path) {
  std::vector<std::unique_ptr<RecordingFile>> files;
  std::error_code error;
  if (fs::is_directory(path, error)) {
    for (const std::string& file : files_of_ros2_folder(path)) {
      files.push_back(open_file(file));
    }
  }
  if (files.empty()) {
    files.push_back(open_file(path));
  }
  return files;
}

}  // namespace matchbox_slam
