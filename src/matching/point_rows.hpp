#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// A scan's rows of numbers as bare pointers, which the compiler sees through: those of
/// Correspondences. The loops over them are all of its work that is vectorised.
struct PointRows {
  std::size_t size;
  const double* rotated_x;
  const double* rotated_y;
  const double* offset_x;
  const double* offset_y;
  const double* c;
  const double* s;
  const double* wall;
  const double* present;
  const double* own;
  const double* common;
  const double* information;
};

/// Sums are kept in this many interleaved parts: they can be added in parallel, and are added in
/// the same order by every instruction set.
constexpr std::size_t kLanes = 8;
constexpr std::size_t kFloatLanes = 16;  ///< of those in single precision

/// Sums in their parts, one sum after the other.
template <std::size_t kCount>
using LaneSums = std::array<double, kCount * kLanes>;

/// Of one sum's parts.
[[nodiscard]] inline double sum_of(const double* lanes) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kLanes; ++k) {
    sum += lanes[k];
  }
  return sum;
}

/// Squared distance of the point from its surface when it is (x, y) away from the surface's middle.
[[nodiscard]] inline double square_of(const PointRows& view, std::size_t j, double x, double y) {
  return 0.5 * ((1.0 + view.c[j]) * x * x + 2.0 * view.s[j] * x * y + (1.0 - view.c[j]) * y * y);
}

/// Upper triangle of the information by rows, then the gradient.
void add_normal_equations(const PointRows& view, double kernel_square, double* lanes);

/// Sums of closeness and of cost.
void add_closeness(const PointRows& view, double kernel_square, double step_x, double step_y,
                   double turn, double* lanes);

/// Sums of squared residuals and of their variances for a point's noise of unit variance, of the
/// points as they were measured: those moved onto one wall share their error, so that their
/// residuals no longer show the noise.
/// @param moved_x, moved_y  from where they were measured, base axes [m].
void add_variance(const PointRows& view, const double* moved_x, const double* moved_y,
                  double cosine, double sine, double kernel_square, double* lanes);

/// Sums of what steps and their opposites cost, over what none costs, in turn. With b = k^2 + r^2
/// before a step, after it and after its opposite that is b + q + 2 p and b + q - 2 p: most of
/// the work serves both.
/// @param steps  x, y and turn of each.
void add_costs_of_both(const PointRows& view, float kernel_square, const float* steps,
                       std::size_t count, float* lanes);

/// Points in the axes of the map.
void rotate(const double* x, const double* y, std::size_t size, double cosine, double sine,
            double* rotated_x, double* rotated_y);

/// The cells that points lie in, and which of them came into another one.
/// @param base  less the field's origin [m]; cosine and sine are of the field's heading.
void find_cells(const double* rotated_x, const double* rotated_y, std::size_t size,
                const Pose2& base, const Pose2& field, double cosine, double sine,
                double resolution, std::int32_t* cell_x, std::int32_t* cell_y, std::int32_t* moved);

/// How far points are from their surfaces. Those without one are put to the origin, where they
/// count nothing.
void find_offsets(const double* present, const double* surface_x, const double* surface_y,
                  std::size_t size, double base_x, double base_y, double* rotated_x,
                  double* rotated_y, double* offset_x, double* offset_y);

/// What points add, where those at one surface share its error.
/// @param group_of  the number of each point's surface; points_in counts the points there.
void find_information(const double* present, const double* own, const double* common,
                      const std::int32_t* group_of, const double* points_in, std::size_t size,
                      double* information);

}  // namespace matchbox_slam
