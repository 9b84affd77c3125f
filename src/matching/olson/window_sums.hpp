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

/// Bytes that are summed at once: so many columns of one row, half of them of two, or a quarter of
/// four.
constexpr int kSumBytes = 16;

/// Columns that are summed where so many are wanted: 4, 8, or a multiple of kSumBytes.
[[nodiscard]] constexpr int summed_columns(int columns) {
  return columns <= kSumBytes / 4   ? kSumBytes / 4
         : columns <= kSumBytes / 2 ? kSumBytes / 2
                                    : (columns + kSumBytes - 1) / kSumBytes * kSumBytes;
}

/// Rows that are summed with so many columns.
[[nodiscard]] constexpr int summed_rows(int rows, int columns) {
  const int together = columns < kSumBytes ? kSumBytes / columns : 1;
  return (rows + together - 1) / together * together;
}

/// The sum of the points' windows, each times its weight:
/// sums[row * columns + column] = sum of weight * table[offset + row * pitch + column].
/// @param rows, columns  as they are summed.
void sum_windows(const PointWindows& points, int rows, int columns, std::uint32_t* sums);

/// Adds up the 2 x 2 cells at each point's offset, apart for each class of points, two side by side
/// in one number: sums[2 * class + dy] += weight * (table[offset + dy * pitch] +
/// 2^32 table[offset + dy * pitch + 1]).
void sum_corners(const PointWindows& points, const std::int32_t* classes, std::uint64_t* sums);

}  // namespace matchbox_slam
