#include "matching/olson/window_sums.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

// Vectors of the compiler (GCC and Clang): on each instruction set as many registers as they take.
using Bytes = std::uint8_t __attribute__((vector_size(kSumColumns)));
using Words = std::uint16_t __attribute__((vector_size(2 * kSumColumns)));
using Sums = std::uint32_t __attribute__((vector_size(4 * kSumColumns)));
using Corners = std::uint32_t __attribute__((vector_size(16)));

// As many rows at a time as leave their sums in registers.
constexpr int kMostRows = 6;

// 16 bits hold the sum of bytes whose weights add up to this.
constexpr unsigned kMostWeight = 65535 / 255;

/// Rows [0, kRows) of one vector of columns.
template <int kRows>
__attribute__((always_inline)) inline void add_rows(const PointWindows& points,
                                                    const std::uint8_t* table, int columns,
                                                    std::uint32_t* sums) {
  std::array<Sums, kRows> total{};
  std::size_t i = 0;
  while (i < points.count) {
    std::array<Words, kRows> part{};
    for (unsigned weight = 0; i < points.count; ++i) {
      weight += points.weights[i];
      if (weight > kMostWeight) {
        break;
      }
      const std::uint8_t* row = table + points.offsets[i];
      for (int r = 0; r < kRows; ++r, row += points.pitch) {
        Bytes bytes;
        std::memcpy(&bytes, row, sizeof(bytes));
        part[static_cast<std::size_t>(r)] +=
            __builtin_convertvector(bytes, Words) * points.weights[i];
      }
    }
    for (std::size_t r = 0; r < kRows; ++r) {
      total[r] += __builtin_convertvector(part[r], Sums);
    }
  }
  for (std::size_t r = 0; r < kRows; ++r) {
    std::memcpy(sums + r * static_cast<std::size_t>(columns), &total[r], sizeof(Sums));
  }
}

MATCHBOX_SIMD_CLONES void add_some_rows(const PointWindows& points, const std::uint8_t* table,
                                        int rows, int columns, std::uint32_t* sums) {
  switch (rows) {
    case 1:
      return add_rows<1>(points, table, columns, sums);
    case 2:
      return add_rows<2>(points, table, columns, sums);
    case 3:
      return add_rows<3>(points, table, columns, sums);
    case 4:
      return add_rows<4>(points, table, columns, sums);
    case 5:
      return add_rows<5>(points, table, columns, sums);
    default:
      return add_rows<kMostRows>(points, table, columns, sums);
  }
}

}  // namespace

void sum_windows(const PointWindows& points, int rows, int columns, std::uint32_t* sums) {
  const int parts = (rows + kMostRows - 1) / kMostRows;
  for (int part = 0; part < parts; ++part) {
    const int first = rows * part / parts;
    const int count = rows * (part + 1) / parts - first;
    for (int column = 0; column < columns; column += kSumColumns) {
      add_some_rows(points, points.table + first * points.pitch + column, count, columns,
                    sums + static_cast<std::ptrdiff_t>(first) * columns + column);
    }
  }
}

void sum_corners(const PointWindows& points, const std::int32_t* classes, std::uint32_t* sums) {
  for (std::size_t i = 0; i < points.count; ++i) {
    const std::uint8_t* cell = points.table + points.offsets[i];
    const Corners corners = {cell[0], cell[1], cell[points.pitch], cell[points.pitch + 1]};
    Corners sum;
    std::uint32_t* to = sums + static_cast<std::ptrdiff_t>(4) * classes[i];
    std::memcpy(&sum, to, sizeof(sum));
    sum += corners * points.weights[i];
    std::memcpy(to, &sum, sizeof(sum));
  }
}

}  // namespace matchbox_slam
