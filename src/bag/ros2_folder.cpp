#include "bag/ros2_folder.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>

#include "bag/bag_error.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";

std::vector<std::string> named_files(const fs::path& metadata) {
  try {
    std::vector<std::string> names;
    const YAML::Node information = YAML::LoadFile(metadata.string())["rosbag2_bagfile_information"];
    for (const YAML::Node& name : information["relative_file_paths"]) {
      names.push_back(name.as<std::string>());
    }
    return names;
  } catch (const YAML::Exception& error) {
    throw BagError(
        fmt::format("'{}' is no metadata of a bag of ROS 2 ({}); give its .db3 or .mcap files "
                    "instead of the folder",
                    metadata.string(), error.what()));
  }
}

/// A file of the folder; the first versions of ROS 2 named it with the folder's name before it.
std::string place_of(const fs::path& folder, const std::string& name) {
  const fs::path named = folder / name;
  const fs::path here = folder / fs::path(name).filename();
  // Of files that were packed as a whole, what they were unpacked to comes first.
  const auto unpacked = [](fs::path place) {
    return place.extension() == ".zstd" ? place.replace_extension() : place;
  };
  for (const fs::path& place : {unpacked(named), unpacked(here), named, here}) {
    std::error_code error;
    if (fs::is_regular_file(place, error)) {
      return place.string();
    }
  }
  throw BagError(fmt::format(
      "bag '{}' has no file '{}', which its {} names; give those that there are by themselves",
      folder.string(), name, kMetadata));
}

}  // namespace

std::vector<std::string> files_of_ros2_folder(const std::string& folder_name) {
  const fs::path folder(folder_name);
  std::vector<std::string> files;
  std::error_code error;
  if (fs::is_regular_file(folder / kMetadata, error)) {
    for (const std::string& name : named_files(folder / kMetadata)) {
      files.push_back(place_of(folder, name));
    }
  }
  if (!files.empty()) {
    return files;
  }
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".db3" || ending == ".mcap") {
      files.push_back(entry.path().string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace matchbox_slam
