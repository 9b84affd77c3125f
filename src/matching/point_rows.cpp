#include "matching/point_rows.hpp"

#include <algorithm>

#include "common/simd.hpp"
#include "matchbox_slam/map/grid_geometry.hpp"

namespace matchbox_slam {
MATCHBOX_SIMD_CLONES void add_normal_equations(const PointRows& view, double kernel_square,
                                               double* __restrict__ lanes) {
  for (std::size_t i = 0; i < view.size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double rotated_x = view.rotated_x[j];
      const double rotated_y = view.rotated_y[j];
      const double p_xx = 0.5 * (1.0 + view.c[j]);
      const double p_xy = 0.5 * view.s[j];
      const double p_yy = 0.5 * (1.0 - view.c[j]);
      const double pull_x = p_xx * view.offset_x[j] + p_xy * view.offset_y[j];
      const double pull_y = p_xy * view.offset_x[j] + p_yy * view.offset_y[j];
      const double square = view.offset_x[j] * pull_x + view.offset_y[j] * pull_y;
      const double closeness = kernel_square / (kernel_square + square);
      const double w = view.information[j] * closeness * closeness;
      // Columns of the Jacobian: (1, 0), (0, 1), (-rotated_y, rotated_x).
      const double turn_x = p_xy * rotated_x - p_xx * rotated_y;
      const double turn_y = p_yy * rotated_x - p_xy * rotated_y;
      lanes[0 * kLanes + k] += w * p_xx;
      lanes[1 * kLanes + k] += w * p_xy;
      lanes[2 * kLanes + k] += w * turn_x;
      lanes[3 * kLanes + k] += w * p_yy;
      lanes[4 * kLanes + k] += w * turn_y;
      lanes[5 * kLanes + k] += w * (rotated_x * turn_y - rotated_y * turn_x);
      lanes[6 * kLanes + k] += w * pull_x;
      lanes[7 * kLanes + k] += w * pull_y;
      lanes[8 * kLanes + k] += w * (rotated_x * pull_y - rotated_y * pull_x);
    }
  }
}

MATCHBOX_SIMD_CLONES void add_closeness(const PointRows& view, double kernel_square, double step_x,
                                        double step_y, double turn, double* __restrict__ lanes) {
  for (std::size_t i = 0; i < view.size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double x = view.offset_x[j] + step_x - turn * view.rotated_y[j];
      const double y = view.offset_y[j] + step_y + turn * view.rotated_x[j];
      const double square = square_of(view, j, x, y);
      const double closeness = kernel_square / (kernel_square + square);
      lanes[0 * kLanes + k] += view.present[j] * view.wall[j] * closeness;
      lanes[1 * kLanes + k] += 0.5 * view.information[j] * square * closeness;
    }
  }
}

MATCHBOX_SIMD_CLONES void add_variance(const PointRows& view, const double* moved_x,
                                       const double* moved_y, double cosine, double sine,
                                       double kernel_square, double* __restrict__ lanes) {
  for (std::size_t i = 0; i < view.size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double x = view.offset_x[j] - (cosine * moved_x[j] - sine * moved_y[j]);
      const double y = view.offset_y[j] - (sine * moved_x[j] + cosine * moved_y[j]);
      const double square = square_of(view, j, x, y);
      const double closeness = kernel_square / (kernel_square + square);
      // Surfaces without a direction count little, and walls across a surface: there the distance
      // is that between hits, and not noise.
      const double directed = view.c[j] * view.c[j] + view.s[j] * view.s[j];
      const double w =
          directed / std::max(1.0, view.own[j]) * view.information[j] * closeness * closeness;
      lanes[0 * kLanes + k] += w * square;
      lanes[1 * kLanes + k] += w * (view.own[j] + view.common[j]);
    }
  }
}

MATCHBOX_SIMD_CLONES void add_costs_of_both(const PointRows& view, float kernel_square,
                                            const float* __restrict__ steps, std::size_t count,
                                            float* __restrict__ lanes) {
  using Numbers = std::array<float, kFloatLanes>;
  for (std::size_t i = 0; i < view.size; i += kFloatLanes) {
    alignas(64) Numbers rotated_x, rotated_y, p_xx, p_xy, p_yy, pull_x, pull_y, before, full, here;
#pragma GCC unroll 1
    for (std::size_t k = 0; k < kFloatLanes; ++k) {
      const std::size_t j = i + k;
      const auto x = static_cast<float>(view.offset_x[j]);
      const auto y = static_cast<float>(view.offset_y[j]);
      const auto c = static_cast<float>(view.c[j]);
      const auto s = static_cast<float>(view.s[j]);
      rotated_x[k] = static_cast<float>(view.rotated_x[j]);
      rotated_y[k] = static_cast<float>(view.rotated_y[j]);
      p_xx[k] = 0.5F * (1.0F + c);
      p_xy[k] = s;
      p_yy[k] = 0.5F * (1.0F - c);
      pull_x[k] = (1.0F + c) * x + s * y;
      pull_y[k] = s * x + (1.0F - c) * y;
      before[k] = kernel_square + 0.5F * (x * pull_x[k] + y * pull_y[k]);
      full[k] = 0.5F * static_cast<float>(view.information[j]) * kernel_square * kernel_square;
      here[k] = full[k] / before[k];
    }
    for (std::size_t step = 0; step < count; ++step) {
      const float step_x = steps[3 * step];
      const float step_y = steps[3 * step + 1];
      const float turn = steps[3 * step + 2];
      float* there = lanes + 2 * kFloatLanes * step;
      float* back = there + kFloatLanes;
#pragma GCC unroll 1
      for (std::size_t k = 0; k < kFloatLanes; ++k) {
        const float x = step_x - turn * rotated_y[k];
        const float y = step_y + turn * rotated_x[k];
        const float p = x * pull_x[k] + y * pull_y[k];
        const float middle = before[k] + (x * (x * p_xx[k] + y * p_xy[k]) + y * y * p_yy[k]);
        const float after = middle + p;
        const float opposite = middle - p;
        const float share = full[k] / (after * opposite);  // one division for both
        there[k] += here[k] - share * opposite;
        back[k] += here[k] - share * after;
      }
    }
  }
}

MATCHBOX_SIMD_CLONES void rotate(const double* __restrict__ x, const double* __restrict__ y,
                                 std::size_t size, double cosine, double sine,
                                 double* __restrict__ rotated_x, double* __restrict__ rotated_y) {
  for (std::size_t j = 0; j < size; ++j) {
    rotated_x[j] = cosine * x[j] - sine * y[j];
    rotated_y[j] = sine * x[j] + cosine * y[j];
  }
}

MATCHBOX_SIMD_CLONES void find_cells(const double* __restrict__ rotated_x,
                                     const double* __restrict__ rotated_y, std::size_t size,
                                     const Pose2& base, const Pose2& field, double cosine,
                                     double sine, double resolution,
                                     std::int32_t* __restrict__ cell_x,
                                     std::int32_t* __restrict__ cell_y,
                                     std::int32_t* __restrict__ moved) {
  const double cells = 1.0 / resolution;
  const double base_x = base.x;
  const double base_y = base.y;
  const double field_x = field.x;
  const double field_y = field.y;
  for (std::size_t j = 0; j < size; ++j) {
    const double x = rotated_x[j] + base_x - field_x;
    const double y = rotated_y[j] + base_y - field_y;
    const std::int32_t here_x = cell_index((cosine * x + sine * y) * cells);
    const std::int32_t here_y = cell_index((cosine * y - sine * x) * cells);
    moved[j] |= (here_x ^ cell_x[j]) | (here_y ^ cell_y[j]);
    cell_x[j] = here_x;
    cell_y[j] = here_y;
  }
}

MATCHBOX_SIMD_CLONES void find_offsets(const double* __restrict__ present,
                                       const double* __restrict__ surface_x,
                                       const double* __restrict__ surface_y, std::size_t size,
                                       double base_x, double base_y, double* __restrict__ rotated_x,
                                       double* __restrict__ rotated_y,
                                       double* __restrict__ offset_x,
                                       double* __restrict__ offset_y) {
  for (std::size_t j = 0; j < size; ++j) {
    const bool counts = present[j] > 0.0;
    offset_x[j] = counts ? rotated_x[j] + base_x - surface_x[j] : 0.0;
    offset_y[j] = counts ? rotated_y[j] + base_y - surface_y[j] : 0.0;
    rotated_x[j] = counts ? rotated_x[j] : 0.0;
    rotated_y[j] = counts ? rotated_y[j] : 0.0;
  }
}

MATCHBOX_SIMD_CLONES void find_information(const double* __restrict__ present,
                                           const double* __restrict__ own,
                                           const double* __restrict__ common,
                                           const std::int32_t* __restrict__ group_of,
                                           const double* __restrict__ points_in, std::size_t size,
                                           double* __restrict__ information) {
  for (std::size_t j = 0; j < size; ++j) {
    const double variance = own[j] + points_in[group_of[j]] * common[j];
    information[j] = present[j] > 0.0 ? 1.0 / variance : 0.0;
  }
}

}  // namespace matchbox_slam
