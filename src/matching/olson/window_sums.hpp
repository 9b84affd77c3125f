#pragma once

#include <cstddef>
#include <cstdint>

namespace matchbox_slam {

/// A table of bytes, and where in it each point's window begins.
struct PointWindows {
  const std::uint8_t* table = nullptr;
  std::ptrdiff_t pitch = 0;  ///< from row to row
  const std::int32_t* offsets = nullptr;
  const std::uint16_t* weights = nullptr;  ///< 1...64
  std::size_t count = 0;
};

/// Columns are summed in whole vectors; rows are read up to the next multiple of this.
constexpr int kSumColumns = 16;

/// The sum of the points' windows, each times its weight:
/// sums[row * columns + column] = sum of weight * table[offset + row * pitch + column].
/// All columns of a row are added at once; the work is rows times columns / 16 vectors a point.
/// @param columns  multiple of kSumColumns.
void sum_windows(const PointWindows& points, int rows, int columns, std::uint32_t* sums);

/// Adds up the 2 x 2 cells at each point's offset, apart for each class of points:
/// sums[4 * class + 2 * dy + dx] += weight * table[offset + dy * pitch + dx].
void sum_corners(const PointWindows& points, const std::int32_t* classes, std::uint32_t* sums);

}  // namespace matchbox_slam
