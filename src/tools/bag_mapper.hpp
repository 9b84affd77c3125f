#pragma once

#include <optional>
#include <string>

#include "run/run_dialog.hpp"
#include "tools/recording_request.hpp"

namespace matchbox_slam {

/// What map_bag is asked to do; what is not given keeps its default.
struct MapBagRequest : RecordingRequest {
  std::string map;         ///< file to go on with; empty: a new map
  bool overwrite = false;  ///< that one, where the results are to go there
  std::string convert;     ///< bag to write in place of a map; empty: a map
  std::optional<std::string> matcher;
  std::string events;                ///< file; empty: nothing happens between the scans
  std::optional<std::string> movie;  ///< a .gif, or a folder; none: no movie
  std::optional<std::string> pose;   ///< X,Y,THETA of the base in the map at the first scan
};

/// Maps a bag from end to end: reads it in the order of its recording, runs the engine on every
/// scan that tf covers, and writes trajectory.tum, trajectory_live.tum, odometry.tum,
/// key_scans.tum, graph.g2o, scans.csv, map.pgm, map.yaml, map.png, map.slam, report.json and
/// report.html into the folder, and a movie where one is asked for. The same request gives the same
/// bytes in all but the two reports, with any number of threads.
///
/// Throws ConfigurationError when the request makes no sense for the bag; FileError when results
/// cannot be written, which is tried before the work; BagError when nothing can be read. Where a
/// bag turns out damaged later, it writes the results of the part before and then throws BagError.
/// Interrupted, it writes the results up to there, or throws Interrupted when there are none yet.
void map_bag(const MapBagRequest& request, const RunDialog& dialog);

}  // namespace matchbox_slam
