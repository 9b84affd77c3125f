#pragma once

#include <cstdint>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {

/// From which probability on a cell is written as occupied, and up to which as free.
struct MapThresholds {
  double occupied = 0.65;
  double free = 0.25;
};

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// A map as map_server's files hold it: an image with a place in the map frame.
struct MapImage {
  static constexpr std::uint8_t kOccupiedPixel = 0;
  static constexpr std::uint8_t kUnknownPixel = 205;
  static constexpr std::uint8_t kFreePixel = 254;

  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< row by row, the top one (largest y) first
  double resolution = 0.05;          ///< [m] a pixel
  Pose2 origin;         ///< lower left corner of the lower left pixel, in the map frame
  bool negate = false;  ///< bright pixels are the occupied ones
  double occupied_threshold = 0.65;  ///< of (255 - pixel) / 255; as map_saver writes it
  double free_threshold = 0.196;     ///< likewise

  /// The pixel of a cell, counted from the lower left one, which is (0, 0); unchecked.
  [[nodiscard]] std::uint8_t pixel(const Cell& cell) const {
    return pixels[static_cast<std::size_t>(height - 1 - cell.y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(cell.x)];
  }

  /// What map_server would make of a cell, counted from the lower left one; unchecked.
  [[nodiscard]] CellState state(const Cell& cell) const;
};

/// The observed part of the map as an image; one unknown pixel when nothing was observed.
/// @param thresholds  0 <= free < occupied <= 1. Throws std::invalid_argument otherwise.
[[nodiscard]] MapImage make_map_image(const OccupancyGrid& grid,
                                      const MapThresholds& thresholds = {});

}  // namespace matchbox_slam
