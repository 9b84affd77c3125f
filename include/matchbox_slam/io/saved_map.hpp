#pragma once

#include <string>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// A map as bytes, from which mapping goes on to the bit as if it had never stopped: every cell
/// with all that is known of it, the walls below the size of a cell, the key scans as they were
/// measured and joined to a graph, and how the base moved. Compressed and with a checksum (gzip).
void write_saved_map(const EngineState& map, const ByteSink& sink);

/// The same in one piece.
[[nodiscard]] std::string to_saved_map(const EngineState& map);

/// Reads what `write_saved_map` wrote, or what it wrote in release 1.0. Throws FileError for a file
/// that is none, is cut off or damaged, comes from another version of the format, or whose cells
/// span more than `max_cells`.
[[nodiscard]] EngineState read_saved_map(const std::string& path,
                                         double max_cells = MapOptions{}.max_cells);

/// A map to localise in, or to go on with, from an image, as of map_server, of any resolution and
/// however it is turned. Occupied pixels become walls, each where those that touch it lie on a
/// line, so that a scan can be matched to a fraction of a cell. Its key scans are what a laser
/// would see from its free ground (see `image_views`); pose and covariance are left as they are by
/// default. Throws FileError for an image without a wall, or that is larger than `max_cells`.
/// `path` is for error texts.
[[nodiscard]] EngineState map_from_image(const MapImage& image, const std::string& path,
                                         const MapOptions& map_options,
                                         const LikelihoodFieldOptions& field_options);

/// Reads either: a path that ends in ".yaml" is an image, one in ".slam" a saved map.
/// Throws FileError or ConfigurationError.
[[nodiscard]] EngineState read_engine_state(const std::string& path, const EngineOptions& options);

}  // namespace matchbox_slam
