// The core builds without ROS, so none of its files may include a header of ROS or of pluginlib.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace matchbox_slam {
namespace {

const std::vector<std::string> kRooms = {"common", "geometry",   "sensor",     "map", "matching",
                                         "slam",   "simulation", "evaluation", "io"};

/// Headers with a folder in their name that the core may include. Whatever else there is belongs to
/// a library that it must not know.
bool may_include(const std::string& header) {
  if (header.find('/') == std::string::npos) {
    return true;  // the standard library, or a neighbour
  }
  for (const std::string& room : kRooms) {
    if (header.rfind("matchbox_slam/" + room + "/", 0) == 0) {
      return true;
    }
  }
  return header.rfind("Eigen/", 0) == 0 || header.rfind("yaml-cpp/", 0) == 0 ||
         header.rfind("opencv2/", 0) == 0 || header.rfind("sys/", 0) == 0;
}

TEST(Core, IncludesNothingOfRos) {
  namespace fs = std::filesystem;
  const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  int files = 0;
  for (const std::string top : {"include/matchbox_slam", "src"}) {
    for (const std::string& room : kRooms) {
      const fs::path folder = fs::path(MATCHBOX_SOURCE_DIR) / top / room;
      if (!fs::exists(folder)) {
        continue;  // a room of headers only
      }
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) {
          continue;
        }
        ++files;
        std::ifstream stream(entry.path());
        std::string line;
        std::smatch match;
        while (std::getline(stream, line)) {
          if (std::regex_search(line, match, include)) {
            EXPECT_TRUE(may_include(match[1])) << entry.path() << ": " << line;
          }
        }
      }
    }
  }
  EXPECT_GE(files, 60) << "the sources are elsewhere";
}

TEST(Core, TheCheckKnowsWhatItMayNotInclude) {
  for (const char* header : {"ros/ros.h", "pluginlib/class_list_macros.hpp", "tf2/buffer_core.h",
                             "sensor_msgs/LaserScan.h", "matchbox_slam/ros/slam_node.hpp"}) {
    EXPECT_FALSE(may_include(header)) << header;
  }
  for (const char* header : {"vector", "png.h", "Eigen/Core", "matchbox_slam/map/tiled_grid.hpp"}) {
    EXPECT_TRUE(may_include(header)) << header;
  }
}

}  // namespace
}  // namespace matchbox_slam
