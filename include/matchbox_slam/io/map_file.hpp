#pragma once

#include <string>
#include <vector>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/map/map_image.hpp"

namespace matchbox_slam {

/// In what an image is written that map_server reads.
enum class MapFormat {
  kPgm,  ///< `base_path` + ".pgm", as map_saver does
  kPng,  ///< `base_path` + ".occupancy.png", since ".png" is the picture for people
};

/// The image and `base_path` + ".yaml", with which map_server reads it.
[[nodiscard]] std::vector<FileContents> map_files(const std::string& base_path, const MapImage& map,
                                                  MapFormat format = MapFormat::kPgm);

/// Writes these files; both or none of them. Throws FileError.
void write_map(const std::string& base_path, const MapImage& map,
               MapFormat format = MapFormat::kPgm);

/// Reads a map from its YAML file and the image that this names, relative to its own folder: a
/// binary PGM, or a PNG, gray or in colours, which are averaged as map_server does: with alpha in
/// the mode `trinary`, without it in `scale` and `raw`. In these two a cell has a probability,
/// which is made one of the three states as map_saver does. Throws FileError naming the file and
/// what is wrong with it.
[[nodiscard]] MapImage read_map(const std::string& yaml_path);

}  // namespace matchbox_slam
