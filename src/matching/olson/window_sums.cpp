#include "matching/olson/window_sums.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

// Vectors of the compiler (GCC and Clang): on each instruction set as many registers as they take.
using Bytes = std::uint8_t __attribute__((vector_size(kSumBytes)));
using Quads = std::uint32_t __attribute__((vector_size(kSumBytes)));
using Octets = std::uint64_t __attribute__((vector_size(kSumBytes)));
using Words = std::uint16_t __attribute__((vector_size(2 * kSumBytes)));
using Sums = std::uint32_t __attribute__((vector_size(4 * kSumBytes)));

// As many at a time as leave their sums in registers.
constexpr int kMostVectors = 6;

// 16 bits hold the sum of bytes whose weights add up to this.
constexpr unsigned kMostWeight = 65535 / 255;

template <typename Value>
Value read(const std::uint8_t* from) {
  Value value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

/// Rows of so many columns one after the other.
template <int kColumns>
__attribute__((always_inline)) inline Bytes read_rows(const std::uint8_t* from,
                                                      std::ptrdiff_t pitch) {
  if constexpr (kColumns == kSumBytes) {
    return read<Bytes>(from);
  } else if constexpr (kColumns == kSumBytes / 2) {
    const Octets rows = {read<std::uint64_t>(from), read<std::uint64_t>(from + pitch)};
    return reinterpret_cast<Bytes>(rows);
  } else {
    const Quads rows = {read<std::uint32_t>(from), read<std::uint32_t>(from + pitch),
                        read<std::uint32_t>(from + 2 * pitch),
                        read<std::uint32_t>(from + 3 * pitch)};
    return reinterpret_cast<Bytes>(rows);
  }
}

/// So many vectors, one above the other.
/// @param step  from the sums of one to those of the next.
template <int kColumns, int kVectors>
__attribute__((always_inline)) inline void add_vectors(const PointWindows& points,
                                                       const std::uint8_t* table,
                                                       std::ptrdiff_t step, std::uint32_t* sums) {
  const std::ptrdiff_t next = kSumBytes / kColumns * points.pitch;
  std::array<Sums, kVectors> total{};
  std::size_t i = 0;
  while (i < points.count) {
    std::array<Words, kVectors> part{};
    for (unsigned weight = 0; i < points.count; ++i) {
      weight += points.weights[i];
      if (weight > kMostWeight) {
        break;
      }
      const std::uint8_t* window = table + points.offsets[i];
      for (std::size_t v = 0; v < kVectors; ++v, window += next) {
        part[v] += __builtin_convertvector(read_rows<kColumns>(window, points.pitch), Words) *
                   points.weights[i];
      }
    }
    for (std::size_t v = 0; v < kVectors; ++v) {
      total[v] += __builtin_convertvector(part[v], Sums);
    }
  }
  for (std::size_t v = 0; v < kVectors; ++v) {
    std::memcpy(sums + static_cast<std::ptrdiff_t>(v) * step, &total[v], sizeof(Sums));
  }
}

template <int kColumns>
__attribute__((always_inline)) inline void add_column(const PointWindows& points,
                                                      const std::uint8_t* table, int vectors,
                                                      std::ptrdiff_t step, std::uint32_t* sums) {
  switch (vectors) {
    case 1:
      return add_vectors<kColumns, 1>(points, table, step, sums);
    case 2:
      return add_vectors<kColumns, 2>(points, table, step, sums);
    case 3:
      return add_vectors<kColumns, 3>(points, table, step, sums);
    case 4:
      return add_vectors<kColumns, 4>(points, table, step, sums);
    case 5:
      return add_vectors<kColumns, 5>(points, table, step, sums);
    default:
      return add_vectors<kColumns, kMostVectors>(points, table, step, sums);
  }
}

MATCHBOX_SIMD_CLONES void add_some(const PointWindows& points, const std::uint8_t* table,
                                   int vectors, int columns, std::uint32_t* sums) {
  switch (columns) {
    case kSumBytes / 4:
      return add_column<kSumBytes / 4>(points, table, vectors, kSumBytes, sums);
    case kSumBytes / 2:
      return add_column<kSumBytes / 2>(points, table, vectors, kSumBytes, sums);
    default:
      return add_column<kSumBytes>(points, table, vectors, columns, sums);
  }
}

}  // namespace

void sum_windows(const PointWindows& points, int rows, int columns, std::uint32_t* sums) {
  const int rows_of_vector = columns < kSumBytes ? kSumBytes / columns : 1;
  const int vectors = rows / rows_of_vector;
  const int parts = (vectors + kMostVectors - 1) / kMostVectors;
  for (int part = 0; part < parts; ++part) {
    const int first = vectors * part / parts;
    const int count = vectors * (part + 1) / parts - first;
    const int row = first * rows_of_vector;
    for (int column = 0; column < columns; column += kSumBytes) {
      add_some(points, points.table + row * points.pitch + column, count, columns,
               sums + static_cast<std::ptrdiff_t>(row) * columns + column);
    }
  }
}

void sum_corners(const PointWindows& points, const std::int32_t* classes, std::uint64_t* sums) {
  const auto pair_at = [](const std::uint8_t* cell) {
    return cell[0] | static_cast<std::uint64_t>(cell[1]) << 32U;
  };
  for (std::size_t i = 0; i < points.count; ++i) {
    const std::uint8_t* cell = points.table + points.offsets[i];
    const std::uint64_t weight = points.weights[i];
    std::uint64_t* to = sums + static_cast<std::ptrdiff_t>(2) * classes[i];
    to[0] += weight * pair_at(cell);
    to[1] += weight * pair_at(cell + points.pitch);
  }
}

}  // namespace matchbox_slam
