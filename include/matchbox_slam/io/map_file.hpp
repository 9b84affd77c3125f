#pragma once

#include <string>
#include <vector>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/map/map_image.hpp"

namespace matchbox_slam {

/// The files `base_path` + ".pgm" and ".yaml" as map_server's map_saver writes them.
[[nodiscard]] std::vector<FileContents> map_files(const std::string& base_path,
                                                  const MapImage& map);

/// Writes `base_path` + ".pgm" and ".yaml" as map_server's map_saver does; both or none of them.
/// Throws FileError.
void write_map(const std::string& base_path, const MapImage& map);

/// Reads a map from its YAML file and the binary PGM that this names, relative to its own folder.
/// Throws FileError naming the file and what is wrong with it.
[[nodiscard]] MapImage read_map(const std::string& yaml_path);

}  // namespace matchbox_slam
