#pragma once

#include <map>

#include "io/map_archive.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

// What a saved map is made of. Reading throws FileError for what no map could have made.

void write_grids(const SlamMap& map, MapWriter& writer);
[[nodiscard]] SlamMap read_grids(MapReader& reader);

/// Version 1 of the format has points alone.
void write_key_scans(const KeyScans& key_scans, MapWriter& writer);
[[nodiscard]] KeyScans read_key_scans(bool version_1, MapReader& reader);

/// map_from_base by laser, as in MapPart.
void write_last_inserted(const std::map<int, Pose2>& last_inserted, MapWriter& writer);
[[nodiscard]] std::map<int, Pose2> read_last_inserted(MapReader& reader);

void write_whereabouts(const Whereabouts& whereabouts, MapWriter& writer);
[[nodiscard]] Whereabouts read_whereabouts(MapReader& reader);

}  // namespace matchbox_slam
