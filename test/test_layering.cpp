// The modules lie one above the other (doc/how_it_works.md): a file includes headers of
// its own module and of those below. The core builds without ROS, so none of its files may know a
// header of ROS or of pluginlib.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

struct Module {
  std::set<std::string> below;      ///< modules whose headers it may include
  std::set<std::string> libraries;  ///< folders of libraries' headers that it may include
  bool knows_ros = false;           ///< then it may include any library
};

const std::set<std::string> kCore = {"geometry", "common", "sensor", "map", "matching",
                                     "motion",   "lasers", "graph",  "slam"};

std::set<std::string> operator+(std::set<std::string> a, const std::set<std::string>& b) {
  a.insert(b.begin(), b.end());
  return a;
}

const std::map<std::string, Module>& modules() {
  static const std::set<std::string> kFiles = kCore + std::set<std::string>{"evaluation", "io"};
  static const std::set<std::string> kRun = kFiles + std::set<std::string>{"odometry", "merging"};
  static const std::set<std::string> kRos = kRun + std::set<std::string>{"run", "ros"};
  static const std::map<std::string, Module> kAll = {
      {"geometry", {{}, {"Eigen"}}},
      {"common", {{"geometry"}, {"Eigen"}}},
      {"sensor", {{"geometry", "common"}, {"Eigen"}}},
      {"map", {{"geometry", "common", "sensor"}, {"Eigen"}}},
      {"matching", {{"geometry", "common", "sensor", "map"}, {"Eigen"}}},
      {"graph", {{"geometry", "common"}, {"Eigen", "ceres"}}},
      {"motion", {{"geometry", "common", "sensor", "map", "matching"}, {"Eigen"}}},
      {"lasers", {{"geometry", "common", "sensor", "map", "matching"}, {"Eigen"}}},
      {"slam",
       {{"geometry", "common", "sensor", "map", "matching", "motion", "lasers", "graph"},
        {"Eigen"}}},
      {"odometry", {kCore, {"Eigen"}}},
      {"merging", {kCore, {"Eigen"}}},
      {"simulation", {{"geometry", "common", "sensor"}, {"Eigen"}}},
      {"evaluation", {kCore, {"Eigen", "opencv2"}}},
      {"io", {kCore + std::set<std::string>{"evaluation"}, {"Eigen", "fmt", "yaml-cpp", "sys"}}},
      {"run", {kRun, {"Eigen", "fmt", "sys"}}},
      {"ros", {kRun + std::set<std::string>{"run"}, {}, true}},
      {"bag", {kRos + std::set<std::string>{"simulation"}, {}, true}},
      {"node", {kRos, {}, true}},
      {"rviz", {{"geometry", "common"}, {}, true}},
      {"tools", {kRos + std::set<std::string>{"simulation", "bag"}, {}, true}},
  };
  return kAll;
}

/// Of a header, the module that its name begins with; none: it is no header of this package.
std::optional<std::string> module_of(std::string header) {
  const std::string ours = "matchbox_slam/";
  const bool is_public = header.rfind(ours, 0) == 0;
  header = is_public ? header.substr(ours.size()) : header;
  const std::string first = header.substr(0, header.find('/'));
  // ROS has headers in a folder `ros`, too: those are its own, all in <>, and end in .h.
  const bool is_ours = modules().count(first) != 0 && header.find('/') != std::string::npos &&
                       header.substr(header.rfind('.')) == ".hpp";
  return is_ours ? std::optional(first) : std::nullopt;
}

bool may_include(const std::string& name, const std::string& header) {
  const Module& module = modules().at(name);
  if (const std::optional<std::string> other = module_of(header)) {
    return *other == name || module.below.count(*other) != 0;
  }
  const std::size_t slash = header.find('/');
  return module.knows_ros || slash == std::string::npos ||
         module.libraries.count(header.substr(0, slash)) != 0;
}

std::vector<std::string> headers_included_by(const fs::path& file) {
  const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<std::string> headers;
  std::ifstream stream(file);
  std::string line;
  for (std::smatch match; std::getline(stream, line);) {
    if (std::regex_search(line, match, include)) {
      headers.push_back(match[1]);
    }
  }
  return headers;
}

/// Calls `look(module, file)` for every source of the package.
template <typename Look>
void for_each_source(const Look& look) {
  for (const std::string top : {"include/matchbox_slam", "src"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(MATCHBOX_SOURCE_DIR) / top)) {
      const std::string kind = entry.path().extension().string();
      if (kind == ".hpp" || kind == ".cpp") {
        const fs::path place = fs::relative(entry.path(), fs::path(MATCHBOX_SOURCE_DIR) / top);
        look(place.begin()->string(), entry.path());
      }
    }
  }
}

TEST(Layering, IncludeOnlyWhatLiesBelow) {
  int files = 0;
  for_each_source([&](const std::string& module, const fs::path& file) {
    ASSERT_EQ(modules().count(module), 1U) << file << " lies in no module that this test knows";
    ++files;
    for (const std::string& header : headers_included_by(file)) {
      EXPECT_TRUE(may_include(module, header)) << file << " includes " << header;
    }
  });
  EXPECT_GE(files, 150) << "the sources are elsewhere";
}

TEST(Layering, LieOneAboveTheOther) {
  for (const auto& [name, module] : modules()) {
    for (const std::string& below : module.below) {
      EXPECT_EQ(modules().at(below).below.count(name), 0U) << name << " and " << below;
      for (const std::string& further : modules().at(below).below) {
        EXPECT_EQ(module.below.count(further), 1U)
            << name << " stands on " << below << " and so on " << further;
      }
    }
  }
}

TEST(Layering, PublicHeadersIncludeNoPrivateOnes) {
  for_each_source([&](const std::string& /*module*/, const fs::path& file) {
    if (file.string().find("include/matchbox_slam") == std::string::npos) {
      return;
    }
    for (const std::string& header : headers_included_by(file)) {
      EXPECT_FALSE(module_of(header) && header.rfind("matchbox_slam/", 0) != 0)
          << file << " includes " << header << ", which is not installed";
    }
  });
}

/// The name of what a test is for that is not named after a header: its first line says it.
std::string told_subject_of(const fs::path& test) {
  std::ifstream stream(test);
  std::string line;
  std::getline(stream, line);
  const std::regex subject(R"(^// Of ([a-z0-9_/]+\.(hpp|cpp|launch)))");
  std::smatch match;
  return std::regex_search(line, match, subject) ? match[1].str() : "";
}

bool is_there(const std::string& name) {
  const fs::path top(MATCHBOX_SOURCE_DIR);
  return !name.empty() &&
         (fs::exists(top / "src" / name) || fs::exists(top / "include/matchbox_slam" / name) ||
          fs::exists(top / "launch" / name));
}

TEST(Layering, TestsMirrorThem) {
  const fs::path top = fs::path(MATCHBOX_SOURCE_DIR) / "test";
  int tests = 0;
  for (const auto& entry : fs::recursive_directory_iterator(top)) {
    const fs::path place = fs::relative(entry.path(), top);
    const std::string name = place.stem().string();
    if (modules().count(place.begin()->string()) == 0 || place.extension() != ".cpp" ||
        name.rfind("test_", 0) != 0) {
      continue;
    }
    ++tests;
    const std::string header =
        (place.parent_path() / (name.substr(std::string("test_").size()) + ".hpp")).string();
    const std::vector<std::string> included = headers_included_by(entry.path());
    const bool is_named_after_it =
        std::count(included.begin(), included.end(), header) > 0 ||
        std::count(included.begin(), included.end(), "matchbox_slam/" + header) > 0;
    EXPECT_TRUE(is_named_after_it || is_there(told_subject_of(entry.path())))
        << place << " does not include " << header
        << ", nor does its first line say what it is for: // Of MODULE/NAME.hpp";
  }
  EXPECT_GE(tests, 100) << "the tests are elsewhere";
}

TEST(Layering, TheCheckKnowsWhatItMayNotInclude) {
  for (const char* header :
       {"ros/ros.h", "pluginlib/class_list_macros.hpp", "tf2/buffer_core.h",
        "sensor_msgs/LaserScan.h", "ros/scan_queue.hpp", "matchbox_slam/MatchInfo.h",
        "run/slam_run.hpp", "matchbox_slam/slam/slam_engine.hpp", "yaml-cpp/yaml.h"}) {
    EXPECT_FALSE(may_include("matching", header)) << header;
  }
  for (const char* header : {"vector", "Eigen/Core", "matchbox_slam/map/tiled_grid.hpp",
                             "matching/olson/window_sums.hpp", "sensor/straight_walls.hpp"}) {
    EXPECT_TRUE(may_include("matching", header)) << header;
  }
  EXPECT_FALSE(may_include("ros", "node/slam_node.hpp"));
  EXPECT_TRUE(may_include("ros", "ros/ros.h"));
}

}  // namespace
}  // namespace matchbox_slam
