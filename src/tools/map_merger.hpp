#pragma once

#include <string>
#include <vector>

#include "run/run_dialog.hpp"

namespace matchbox_slam {

/// What merge_maps is asked to do.
struct MergeMapsRequest {
  std::vector<std::string> maps;  ///< saved maps
  std::string out;                ///< folder
  bool overwrite = false;         ///< one of the maps, where the results are to go there
  std::vector<std::string> config_files;
  std::vector<std::string> overrides;  ///< `key=value`
  bool quiet = false;
};

/// Makes one map of saved maps that meet, and writes map.slam, map.pgm, map.yaml, map.png and
/// report.json into the folder, and of each input the trajectory of its key scans, trajectory_1.tum
/// and so on. What does not meet the first one becomes a map of its own, map_2.slam and so on, and
/// a warning tells. All are drawn in cells as the first one has them, unless the configuration
/// says. What an earlier merge left there goes into the folder's earlier/. The same request gives
/// the same bytes in all but report.json.
///
/// Throws ConfigurationError when the request makes no sense; FileError for a file that is no map
/// that can be merged, and when results cannot be written, which is tried before the work.
/// Interrupted, it throws std::runtime_error, and nothing is written.
void merge_maps(const MergeMapsRequest& request, const RunDialog& dialog);

}  // namespace matchbox_slam
