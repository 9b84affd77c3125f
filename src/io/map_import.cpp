#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {
namespace {

constexpr int kNeighbourhood = 3;  // [cells] to each side, in which a wall is taken as straight
constexpr std::size_t kFewestOnLine = 4;  // a guess: half and double were not tried
constexpr double kLineThickness = 0.3;    // of its length, at most; rounder spots tell no direction

// What an image says of a cell, as strong as some scans would have said it.
constexpr double kFreeOccupancy = 0.05;
constexpr double kOccupiedOccupancy = 0.95;

/// Occupied pixels around one, in pixels from the image's lower left corner.
std::vector<Eigen::Vector2d> occupied_around(const MapImage& image, const Cell& pixel) {
  std::vector<Eigen::Vector2d> centers;
  for (int y = std::max(0, pixel.y - kNeighbourhood);
       y <= std::min(image.height - 1, pixel.y + kNeighbourhood); ++y) {
    for (int x = std::max(0, pixel.x - kNeighbourhood);
         x <= std::min(image.width - 1, pixel.x + kNeighbourhood); ++x) {
      if (image.state({x, y}) == CellState::kOccupied) {
        centers.emplace_back(x + 0.5, y + 0.5);
      }
    }
  }
  return centers;
}

/// The wall in an occupied pixel: on the line through its neighbours where they lie on one, else in
/// its centre. In pixels.
SurfaceHit wall_in(const MapImage& image, const Cell& pixel) {
  const Eigen::Vector2d center(pixel.x + 0.5, pixel.y + 0.5);
  const std::vector<Eigen::Vector2d> around = occupied_around(image, pixel);
  if (around.size() < kFewestOnLine) {
    return {center, Eigen::Vector2d::Zero()};
  }
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : around) {
    mean += point / static_cast<double>(around.size());
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : around) {
    scatter += (point - mean) * (point - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);  // ascending
  if (std::sqrt(axes.eigenvalues()(0)) > kLineThickness * std::sqrt(axes.eigenvalues()(1))) {
    return {center, Eigen::Vector2d::Zero()};
  }
  const Eigen::Vector2d normal = axes.eigenvectors().col(0);
  return {center - normal * normal.dot(center - mean), normal};
}

/// Of a copy that was kept, such as map.slam.1, that of what it is a copy of.
std::string extension_of(const std::string& path) {
  const std::filesystem::path whole(path);
  return (whole.extension() == ".1" ? whole.stem() : whole).extension().string();
}

}  // namespace

EngineState map_from_image(const MapImage& image, const std::string& path,
                           const MapOptions& map_options,
                           const LikelihoodFieldOptions& field_options) {
  // map_saver writes six decimals.
  if (std::abs(image.resolution - map_options.resolution) > 1e-6) {
    throw ConfigurationError("map/resolution: " + to_string(map_options.resolution) +
                             " is not allowed with the map '" + path + "'; allowed: its own, " +
                             to_string(image.resolution));
  }
  if (image.origin.theta != 0.0) {
    throw FileError("'" + path + "' is turned by " + to_string(image.origin.theta) +
                    " rad; a map to go on with has to have the yaw 0 in its origin");
  }
  if (static_cast<double>(image.width) * image.height > map_options.max_cells) {
    throw FileError("the map '" + path + "' has " + std::to_string(image.width) + " x " +
                    std::to_string(image.height) +
                    " cells; allowed: " + to_string(map_options.max_cells) +
                    " in all; if it is as large as that, set map/max_cells higher");
  }
  EngineState start{SlamMap(map_options, field_options), {}, {}, {}, 0};
  const auto to_map = [&](const Eigen::Vector2d& pixels) -> Eigen::Vector2d {
    return image.origin.translation() + map_options.resolution * pixels;
  };
  std::vector<SurfaceHit> walls;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const CellState state = image.state({x, y});
      if (state == CellState::kUnknown) {
        continue;
      }
      const bool is_wall = state == CellState::kOccupied;
      start.map.occupancy.blend(start.map.occupancy.geometry().cell_at(to_map({x + 0.5, y + 0.5})),
                                is_wall ? kOccupiedOccupancy : kFreeOccupancy, 1.0);
      if (is_wall) {
        const SurfaceHit wall = wall_in(image, {x, y});
        walls.push_back({to_map(wall.position), wall.normal});
      }
    }
  }
  start.map.field.update(walls, {});
  start.is_of_key_scans = false;
  return start;
}

EngineState read_engine_state(const std::string& path, const EngineOptions& options) {
  if (extension_of(path) == ".yaml") {
    return map_from_image(read_map(path), path, options.map, options.field);
  }
  if (extension_of(path) == ".slam") {
    return read_saved_map(path, options.map.max_cells);
  }
  throw FileError("'" + path +
                  "' is not read as a map; allowed: a .slam file of ~save_map, or a .yaml file as "
                  "of map_server");
}

}  // namespace matchbox_slam
