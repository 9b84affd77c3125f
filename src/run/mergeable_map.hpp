#pragma once

#include <string>

#include "matchbox_slam/slam/engine_state.hpp"

namespace matchbox_slam {

/// A saved map that can be merged with others. Throws ConfigurationError for what people give in
/// place of one, a folder, a recording or an image, saying what to give; FileError for a file that
/// is none, or has no key scans to merge it by.
[[nodiscard]] EngineState read_mergeable_map(const std::string& path, const EngineOptions& options);

/// The highest number of a laser that the map has a key scan of, also in its disconnected
/// components and of what waits to be inserted, as all of it is merged; -1 of a map without.
[[nodiscard]] int last_laser(const EngineState& map);

}  // namespace matchbox_slam
