#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/ros/bag_reader.hpp"

namespace matchbox_slam {

/// What map_bag is asked to do; what is not given is found in the bag or keeps its default.
struct MapBagRequest {
  std::vector<std::string> bags;
  std::string out;  ///< folder
  std::vector<std::string> config_files;
  std::optional<std::string> matcher;
  std::vector<std::string> overrides;  ///< `key=value`
  std::optional<std::string> scan_topic;
  std::optional<std::string> base_frame;
  std::optional<std::string> odom_frame;
  bool no_odometry = false;
  BagPeriod period;
  std::optional<int> seed;
  int threads = 1;
};

/// How the mapper talks to its user, and how the user stops it.
struct MapBagDialog {
  std::function<void(const std::string& line)> inform;
  std::function<void(const std::string& line)> warn;
  std::function<void(double fraction, const std::string& text)> show_progress;
  std::function<bool()> is_interrupted;
};

/// Maps a bag from end to end: reads it in the order of its recording, runs the engine on every
/// scan that tf covers, and writes trajectory.tum, odometry.tum, map.pgm, map.yaml, map.png and
/// report.json into the folder. The same request gives the same bytes in all but the report, with
/// any number of threads.
///
/// Throws ConfigurationError when the request makes no sense for the bag; FileError when results
/// cannot be written, which is tried before the work; BagError when nothing can be read. Where a
/// bag turns out damaged later, it writes the results of the part before and then throws BagError.
void map_bag(const MapBagRequest& request, const MapBagDialog& dialog);

}  // namespace matchbox_slam
