#include "matchbox_slam/matching/correspondences.hpp"

#include <array>
#include <cmath>

#include "matchbox_slam/common/simd.hpp"

namespace matchbox_slam {
namespace {

// Sums are kept in this many interleaved parts: they can be added in parallel, and are added in the
// same order by every instruction set.
constexpr std::size_t kLanes = 8;

template <std::size_t kCount>
using LaneSums = std::array<double, kCount * kLanes>;

double sum_of(const double* lanes) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kLanes; ++k) {
    sum += lanes[k];
  }
  return sum;
}

struct View {
  std::size_t size;
  const double* rotated_x;
  const double* rotated_y;
  const double* offset_x;
  const double* offset_y;
  const double* c;
  const double* s;
  const double* weight;
};

/// Upper triangle of the information by rows, then the gradient.
MATCHBOX_SIMD_CLONES void add_normal_equations(const View& view, double kernel_square,
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
      const double w = view.weight[j] * closeness * closeness;
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

MATCHBOX_SIMD_CLONES void add_closeness(const View& view, double kernel_square, double step_x,
                                        double step_y, double turn, double* __restrict__ lanes) {
  for (std::size_t i = 0; i < view.size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double x = view.offset_x[j] + step_x - turn * view.rotated_y[j];
      const double y = view.offset_y[j] + step_y + turn * view.rotated_x[j];
      const double square =
          0.5 * ((1.0 + view.c[j]) * x * x + 2.0 * view.s[j] * x * y + (1.0 - view.c[j]) * y * y);
      lanes[k] += view.weight[j] * (kernel_square / (kernel_square + square));
    }
  }
}

}  // namespace

Correspondences::Correspondences(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                                 const Pose2& map_from_base) {
  const std::size_t padded = (points.size() + kLanes - 1) / kLanes * kLanes;
  for (auto* array : {&arrays_.rotated_x, &arrays_.rotated_y, &arrays_.offset_x, &arrays_.offset_y,
                      &arrays_.c, &arrays_.s, &arrays_.weight}) {
    array->resize(padded, 0.0);
  }
  const double cosine = std::cos(map_from_base.theta);
  const double sine = std::sin(map_from_base.theta);
  Surface surface;
  std::size_t count = 0;
  for (const ScanPoint& point : points) {
    // What is no number would make the whole sum none.
    if (!point.position.allFinite() || !std::isfinite(point.weight)) {
      continue;
    }
    total_weight_ += point.weight;
    const Eigen::Vector2d rotated(cosine * point.position.x() - sine * point.position.y(),
                                  sine * point.position.x() + cosine * point.position.y());
    const Eigen::Vector2d position = rotated + map_from_base.translation();
    if (!field.nearest_surface(field.geometry().cell_at(position), surface)) {
      continue;
    }
    arrays_.rotated_x[count] = rotated.x();
    arrays_.rotated_y[count] = rotated.y();
    arrays_.offset_x[count] = position.x() - surface.position.x();
    arrays_.offset_y[count] = position.y() - surface.position.y();
    arrays_.c[count] = surface.double_angle.x();
    arrays_.s[count] = surface.double_angle.y();
    arrays_.weight[count] = point.weight;
    ++count;
  }
}

NormalEquations Correspondences::linearise(double kernel) const {
  LaneSums<9> lanes{};
  add_normal_equations({arrays_.weight.size(), arrays_.rotated_x.data(), arrays_.rotated_y.data(),
                        arrays_.offset_x.data(), arrays_.offset_y.data(), arrays_.c.data(),
                        arrays_.s.data(), arrays_.weight.data()},
                       kernel * kernel, lanes.data());
  const auto sum = [&lanes](std::size_t which) { return sum_of(&lanes[which * kLanes]); };
  NormalEquations equations;
  equations.information << sum(0), sum(1), sum(2),  //
      sum(1), sum(3), sum(4),                       //
      sum(2), sum(4), sum(5);
  equations.gradient << sum(6), sum(7), sum(8);
  return equations;
}

double Correspondences::closeness(double kernel, const Eigen::Vector3d& step) const {
  if (!(total_weight_ > 0.0)) {
    return 0.0;
  }
  LaneSums<1> lanes{};
  add_closeness({arrays_.weight.size(), arrays_.rotated_x.data(), arrays_.rotated_y.data(),
                 arrays_.offset_x.data(), arrays_.offset_y.data(), arrays_.c.data(),
                 arrays_.s.data(), arrays_.weight.data()},
                kernel * kernel, step.x(), step.y(), step.z(), lanes.data());
  return sum_of(lanes.data()) / total_weight_;
}

}  // namespace matchbox_slam
