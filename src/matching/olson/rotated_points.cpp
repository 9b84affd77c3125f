#include "matching/olson/rotated_points.hpp"

#include <algorithm>
#include <cstddef>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

/// Rounded towards minus infinity, in basic arithmetic: compilers vectorise it without options that
/// change others. |value| < 2^31.
inline std::int32_t round_down(double value) {
  const auto towards_zero = static_cast<std::int32_t>(value);
  return towards_zero - static_cast<std::int32_t>(value < towards_zero);
}

MATCHBOX_SIMD_CLONES void rotate_arrays(const double* __restrict__ x, const double* __restrict__ y,
                                        std::size_t count, const Rotation& rotation,
                                        std::int32_t* __restrict__ cell_x,
                                        std::int32_t* __restrict__ cell_y,
                                        std::int32_t* __restrict__ step_x,
                                        std::int32_t* __restrict__ step_y) {
  const Rotation by = rotation;  // which no store may change
  const double cells_per_step = 1.0 / by.steps_per_cell;
  const auto steps_per_cell = static_cast<std::int32_t>(by.steps_per_cell);
  for (std::size_t i = 0; i < count; ++i) {
    const double qx = (by.cosine * x[i] - by.sine * y[i]) + by.x;
    const double qy = (by.sine * x[i] + by.cosine * y[i]) + by.y;
    const std::int32_t ux = round_down(qx * by.steps_per_metre);
    const std::int32_t uy = round_down(qy * by.steps_per_metre);
    // In the middle of a step, so that rounding cannot matter.
    const std::int32_t cx = round_down((ux + 0.5) * cells_per_step);
    const std::int32_t cy = round_down((uy + 0.5) * cells_per_step);
    cell_x[i] = cx;
    cell_y[i] = cy;
    step_x[i] = ux - cx * steps_per_cell;
    step_y[i] = uy - cy * steps_per_cell;
  }
}

MATCHBOX_SIMD_CLONES void find_offset_arrays(const std::int32_t* __restrict__ cell_x,
                                             const std::int32_t* __restrict__ cell_y,
                                             const std::uint16_t* __restrict__ weights,
                                             std::size_t count, const CellBox& useful,
                                             const TableLayout& table,
                                             std::int32_t* __restrict__ offsets,
                                             std::uint16_t* __restrict__ useful_weights) {
  const TableLayout layout = table;  // which no store may change
  const std::int32_t min_x = useful.min.x;
  const std::int32_t min_y = useful.min.y;
  const auto width = static_cast<std::uint32_t>(std::max(0, useful.width()));
  const auto height = static_cast<std::uint32_t>(std::max(0, useful.height()));
  const std::int32_t last_phase = (1 << layout.phase_bits) - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const auto is_useful =
        static_cast<std::int32_t>((static_cast<std::uint32_t>(cell_x[i] - min_x) < width) &
                                  (static_cast<std::uint32_t>(cell_y[i] - min_y) < height));
    // Products, since compilers vectorise no choice between values of two sizes.
    const std::int32_t x =
        (is_useful * (cell_x[i] - min_x) + min_x - layout.corner.x) >> layout.grain_bits;
    const std::int32_t y =
        (is_useful * (cell_y[i] - min_y) + min_y - layout.corner.y) >> layout.grain_bits;
    const std::int32_t phase = ((y & last_phase) << layout.phase_bits) + (x & last_phase);
    offsets[i] =
        phase * layout.plane + (y >> layout.phase_bits) * layout.pitch + (x >> layout.phase_bits);
    useful_weights[i] = static_cast<std::uint16_t>(is_useful * weights[i]);
  }
}

}  // namespace

void rotate_points(const PointArrays& points, const Rotation& rotation, RotatedPoints& rotated) {
  const std::size_t count = points.x.size();
  for (auto* array : {&rotated.x, &rotated.y, &rotated.step_x, &rotated.step_y}) {
    array->resize(count);
  }
  rotate_arrays(points.x.data(), points.y.data(), count, rotation, rotated.x.data(),
                rotated.y.data(), rotated.step_x.data(), rotated.step_y.data());
}

void find_offsets(const RotatedPoints& points, const std::vector<std::uint16_t>& weights,
                  const CellBox& useful, const TableLayout& table, std::int32_t* offsets,
                  std::uint16_t* useful_weights) {
  find_offset_arrays(points.x.data(), points.y.data(), weights.data(), weights.size(), useful,
                     table, offsets, useful_weights);
}

}  // namespace matchbox_slam
