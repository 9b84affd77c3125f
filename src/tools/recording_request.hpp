#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bag/bag_scans.hpp"

namespace matchbox_slam {

/// What programs that match the scans of a recording are asked; what is not given keeps its
/// default.
struct RecordingRequest {
  BagRequest recording;
  std::string out;    ///< folder
  std::string debug;  ///< folder for pictures of the first matches; empty: none
  std::vector<std::string> config_files;
  std::vector<std::string> overrides;  ///< `key=value`
  std::optional<int> seed;
  bool quiet = false;
};

/// Defaults of the structs < files < flags of their own < --set. Throws ConfigurationError for what
/// only the node has.
[[nodiscard]] Parameters gather_parameters(const RecordingRequest& request,
                                           const std::optional<std::string>& matcher = {});

/// Throws FileError unless files can be written to the folders.
void require_writable_folders(const RecordingRequest& request);

}  // namespace matchbox_slam
