#pragma once

#include <cstdint>
#include <vector>

#include "matchbox_slam/map/grid_geometry.hpp"
#include "matching/olson/field_window.hpp"

namespace matchbox_slam {

/// The points of the scan in structure of arrays, so that all of them are turned at once.
struct PointArrays {
  std::vector<double> x, y;  ///< [m], base frame
  std::vector<std::uint16_t> weights;

  void clear() {
    x.clear();
    y.clear();
    weights.clear();
  }
};

/// Where the points fall at one rotation without an offset: the cell, and the step within it.
struct RotatedPoints {
  std::vector<std::int32_t> x, y;
  std::vector<std::int32_t> step_x, step_y;  ///< 0...steps per cell - 1
};

/// What turns and moves points from metres of the base to steps of the map.
struct Rotation {
  double cosine, sine;
  double x, y;  ///< [m]
  double steps_per_metre;
  double steps_per_cell;
};

/// Turns and moves all points; `rotated` gets their number of elements.
void rotate_points(const PointArrays& points, const Rotation& rotation, RotatedPoints& rotated);

/// Offsets of the points' windows in a table. Points whose windows do not lie in the table meet
/// nothing: they get the weight 0, and the window of some useful cell.
/// @param useful   cells whose windows lie in the table.
/// @param offsets, useful_weights  the result, one element a point.
void find_offsets(const RotatedPoints& points, const std::vector<std::uint16_t>& weights,
                  const CellBox& useful, const TableLayout& table, std::int32_t* offsets,
                  std::uint16_t* useful_weights);

}  // namespace matchbox_slam
