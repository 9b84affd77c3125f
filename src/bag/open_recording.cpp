#include "bag/open_recording.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <utility>

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
      throw BagError(
          fmt::format("'{}' {}", path,
                      kind.what_to_do.empty()
                          ? "is no bag of version 2.0, no bag of ROS 2 (.db3, .mcap) and no log of "
                            "CARMEN by what is inside it, whatever its name"
                          : kind.what_to_do));
  }
}

bool is_without_bytes(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && fs::file_size(path, error) == 0 && !error;
}

/// A recorder that was stopped as it began another file leaves that one empty.
OpenRecording open_files(const std::vector<std::string>& paths) {
  OpenRecording opened;
  for (const std::string& path : paths) {
    if (is_without_bytes(path)) {
      opened.remarks.push_back(fmt::format("'{}' is empty (0 bytes) and left out", path));
      continue;
    }
    std::unique_ptr<RecordingFile> file = open_file(path);
    if (file->empty()) {
      opened.remarks.push_back(fmt::format("'{}' holds no messages and is left out", path));
    } else {
      opened.files.push_back(std::move(file));
    }
  }
  return opened;
}

}  // namespace

OpenRecording open_recording(const std::string& path) {
  std::vector<std::string> paths;
  if (std::error_code error; fs::is_directory(path, error)) {
    paths = files_of_ros2_folder(path);
  }
  if (paths.empty()) {
    OpenRecording opened;
    opened.files.push_back(open_file(path));
    return opened;
  }
  OpenRecording opened = open_files(paths);
  if (opened.files.empty()) {
    throw BagError(fmt::format("bag '{}' holds no messages in any of its files", path));
  }
  return opened;
}

}  // namespace matchbox_slam
