#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "io/image_views.hpp"
#include "io/map_archive.hpp"
#include "io/map_kind.hpp"
#include "map/image_walls.hpp"
#include "matchbox_slam/geometry/transform2.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {
namespace {

// What an image says of a cell, as strong as some scans would have said it.
constexpr double kFreeOccupancy = 0.05;
constexpr double kOccupiedOccupancy = 0.95;

/// Where an image lies in the map, whatever its pixels' size and however it is turned.
class PlacedImage {
 public:
  explicit PlacedImage(const MapImage& image)
      : size_(image.width, image.height),
        resolution_(image.resolution),
        map_from_image_(image.origin),
        image_from_map_(image.origin.inverse()) {}

  [[nodiscard]] Eigen::Vector2d to_map(const Eigen::Vector2d& pixels) const {
    return map_from_image_ * Eigen::Vector2d(resolution_ * pixels);
  }

  [[nodiscard]] Cell pixel_at(const Eigen::Vector2d& point) const {
    constexpr double kBorderTolerance = 1e-5;  // [pixels]; map_saver writes six decimals of a metre
    const Eigen::Vector2d pixels = image_from_map_ * point / resolution_;
    return {cell_index(pixels.x() + kBorderTolerance), cell_index(pixels.y() + kBorderTolerance)};
  }

  /// Cells of the map that it covers.
  [[nodiscard]] CellBox cells(const GridGeometry& geometry) const {
    CellBox box;
    const Eigen::Vector2d size = size_.cast<double>();
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(size.x(), 0.0),
                                          Eigen::Vector2d(0.0, size.y()), size}) {
      box.include(geometry.cell_at(to_map(corner)));
    }
    return box;
  }

 private:
  Eigen::Vector2i size_;
  double resolution_;
  Transform2 map_from_image_;
  Transform2 image_from_map_;
};

void require_size_of_pixels(const MapImage& image, const std::string& path) {
  constexpr double kSmallest = 0.001;  // [m]
  constexpr double kLargest = 1.0;     // as of map/resolution
  if (!(image.resolution >= kSmallest && image.resolution <= kLargest)) {
    throw FileError(
        fmt::format("the map '{}' has the resolution {}; allowed: {} to {}, in metres a pixel",
                    path, to_string(image.resolution), to_string(kSmallest), to_string(kLargest)));
  }
}

void require_room(const MapImage& image, const CellBox& cells, const std::string& path,
                  double max_cells) {
  if (std::min(cells.min.x, cells.min.y) < -kFarthestCell ||
      std::max(cells.max.x, cells.max.y) > kFarthestCell) {
    throw FileError(
        fmt::format("the map '{}' lies too far from 0, 0: its origin is {}, {}; allowed are {} "
                    "cells of map/resolution; give it an origin near the building",
                    path, to_string(image.origin.x), to_string(image.origin.y), kFarthestCell));
  }
  const double pixels = static_cast<double>(image.width) * image.height;
  const double in_map = static_cast<double>(cells.width()) * cells.height();
  if (std::max(pixels, in_map) > max_cells) {
    throw FileError(
        fmt::format("the map '{}' has {} x {} pixels of {} m, and would take {} x {} cells; "
                    "allowed: {} in all; if it is as large as that, set map/max_cells higher",
                    path, image.width, image.height, to_string(image.resolution), cells.width(),
                    cells.height(), to_string(max_cells)));
  }
}

/// The cells as an image has them. One that holds a wall is occupied, however many pixels it has.
void draw(const ImageWalls& walls, const PlacedImage& placed, const CellBox& cells,
          OccupancyGrid& occupancy) {
  for (int y = cells.min.y; y < cells.max.y; ++y) {
    for (int x = cells.min.x; x < cells.max.x; ++x) {
      const CellState state = walls.state(placed.pixel_at(occupancy.geometry().center({x, y})));
      if (state != CellState::kUnknown) {
        occupancy.blend({x, y}, state == CellState::kFree ? kFreeOccupancy : kOccupiedOccupancy,
                        1.0);
      }
    }
  }
  for (int y = 0; y < walls.height(); ++y) {
    for (int x = 0; x < walls.width(); ++x) {
      if (walls.state({x, y}) == CellState::kOccupied) {
        const Eigen::Vector2d center = placed.to_map({x + 0.5, y + 0.5});
        occupancy.blend(occupancy.geometry().cell_at(center), kOccupiedOccupancy, 1.0);
      }
    }
  }
}

/// Of a copy that was kept, such as map.slam.1, that of what it is a copy of.
std::string extension_of(const std::string& path) {
  const std::filesystem::path whole(path);
  return (whole.extension() == ".1" ? whole.stem() : whole).extension().string();
}

/// What people give in place of a map, and what would do.
std::string text_of_no_map(const std::string& path) {
  const std::string kind = extension_of(path);
  if (std::filesystem::is_directory(path)) {
    return fmt::format("is a folder; give the map in it, as '{}'",
                       (std::filesystem::path(path) / "map.slam").string());
  }
  const auto kinds = {".bag", ".db3", ".mcap", ".log", ".clf", ".gz"};
  if (is_bag(path) || std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) {
    return fmt::format("is a recording; map_bag '{}' --out DIR makes a map of it, DIR/map.slam",
                       path);
  }
  if (kind == ".pgm" || kind == ".png") {
    return "is the image of a map; give the .slam that was saved beside it, or the .yaml that "
           "names the image and says where it lies";
  }
  return "is not read as a map; allowed: a .slam file of map_bag or ~save_map, or a .yaml file as "
         "of map_server";
}

}  // namespace

EngineState map_from_image(const MapImage& image, const std::string& path,
                           const MapOptions& map_options,
                           const LikelihoodFieldOptions& field_options) {
  require_size_of_pixels(image, path);
  EngineState start{SlamMap(map_options, field_options), {}, {}, {}, 0};
  const PlacedImage placed(image);
  const CellBox cells = placed.cells(start.map.occupancy.geometry());
  require_room(image, cells, path, map_options.max_cells);
  const ImageWalls walls(image);
  if (walls.walls().empty()) {
    throw FileError(fmt::format(
        "the map '{}' has no occupied pixel, so that nothing tells where a robot is; occupied are "
        "those whose darkness (255 - pixel) / 255 is above its occupied_thresh, {}{}",
        path, to_string(image.occupied_threshold),
        image.negate ? "; negate is 1: of white pixels it is the brightness"
                     : "; where white pixels are the walls, set negate: 1"));
  }
  draw(walls, placed, cells, start.map.occupancy);
  std::vector<SurfaceHit> surfaces;
  const Pose2 turn{0.0, 0.0, image.origin.theta};
  // Pixels larger than a cell have a piece of wall in each of the cells that it goes through.
  const int pieces = static_cast<int>(std::ceil(image.resolution / map_options.resolution));
  for (const SurfaceHit& face : walls.faces()) {
    const Eigen::Vector2d along(-face.normal.y(), face.normal.x());
    for (int i = 0; i < pieces; ++i) {
      const double off = (i + 0.5) / pieces - 0.5;  // [pixels]
      surfaces.push_back({placed.to_map(face.position + off * along), turn * face.normal});
    }
  }
  start.map.field.update(surfaces, {});
  start.key_scans = image_views(walls, image.resolution, image.origin);
  start.is_of_key_scans = false;
  return start;
}

EngineState read_engine_state(const std::string& path, const EngineOptions& options) {
  const std::string kind = is_bag(path) ? "" : extension_of(path);
  if (kind == ".yaml") {
    return map_from_image(read_map(path), path, options.map, options.field);
  }
  if (kind == ".slam") {
    return read_saved_map(path, options.map.max_cells);
  }
  throw ConfigurationError(fmt::format("'{}' {}", path, text_of_no_map(path)));
}

}  // namespace matchbox_slam
