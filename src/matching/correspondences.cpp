#include "matchbox_slam/matching/correspondences.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

// Sums are kept in this many interleaved parts: they can be added in parallel, and are added in the
// same order by every instruction set.
constexpr std::size_t kLanes = 8;

// Variance of a surface's error that no number of hits averages out, in units of a point's: its
// direction comes from neighbours that share their errors. Half or double of it changes the mean
// NEES of pairs by +5 and -5 %, the median error by up to 2 %.
constexpr double kSurfaceError = 0.25;

// Variance, in the same units and on top of the point's, of the distance to a surface without a
// direction: that of two places anywhere in one cell of 5 cm, 2 (5 cm)^2 / 12, with the default
// noise of 1 cm. Half or double of it changes the median error of pairs by up to 2 %.
constexpr double kBluntness = 4.0;

template <std::size_t kCount>
using LaneSums = std::array<double, kCount * kLanes>;

double sum_of(const double* lanes) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kLanes; ++k) {
    sum += lanes[k];
  }
  return sum;
}

/// The arrays as bare pointers, which the compiler sees through.
struct View {
  std::size_t size;
  const double* rotated_x;
  const double* rotated_y;
  const double* offset_x;
  const double* offset_y;
  const double* c;
  const double* s;
  const double* weight;
  const double* variance;
  const double* information;
};

template <typename Arrays>
View view_of(const Arrays& arrays) {
  return {arrays.weight.size(),     arrays.rotated_x.data(), arrays.rotated_y.data(),
          arrays.offset_x.data(),   arrays.offset_y.data(),  arrays.c.data(),
          arrays.s.data(),          arrays.weight.data(),    arrays.variance.data(),
          arrays.information.data()};
}

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

/// Squared distance of the point from its surface when it is (x, y) away from the surface's middle.
inline double square_of(const View& view, std::size_t j, double x, double y) {
  return 0.5 * ((1.0 + view.c[j]) * x * x + 2.0 * view.s[j] * x * y + (1.0 - view.c[j]) * y * y);
}

/// Sums of closeness and of cost.
MATCHBOX_SIMD_CLONES void add_closeness(const View& view, double kernel_square, double step_x,
                                        double step_y, double turn, double* __restrict__ lanes) {
  for (std::size_t i = 0; i < view.size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double x = view.offset_x[j] + step_x - turn * view.rotated_y[j];
      const double y = view.offset_y[j] + step_y + turn * view.rotated_x[j];
      const double square = square_of(view, j, x, y);
      const double closeness = kernel_square / (kernel_square + square);
      lanes[0 * kLanes + k] += view.weight[j] * closeness;
      lanes[1 * kLanes + k] += 0.5 * view.information[j] * square * closeness;
    }
  }
}

/// Sums of squared residuals and of their variances for a point's noise of unit variance, of the
/// points as they were measured: those moved onto one wall share their error, so that their
/// residuals no longer show the noise.
/// @param moved_x, moved_y  from where they were measured, map axes [m].
MATCHBOX_SIMD_CLONES void add_variance(const View& view, const double* moved_x,
                                       const double* moved_y, double kernel_square,
                                       double* __restrict__ lanes) {
  for (std::size_t i = 0; i < view.size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double square =
          square_of(view, j, view.offset_x[j] - moved_x[j], view.offset_y[j] - moved_y[j]);
      const double closeness = kernel_square / (kernel_square + square);
      // Surfaces without a direction do not count: there the distance is that between hits.
      const double directed = view.c[j] * view.c[j] + view.s[j] * view.s[j];
      const double w = directed * view.information[j] * closeness * closeness;
      lanes[0 * kLanes + k] += w * square;
      lanes[1 * kLanes + k] += w * view.variance[j];
    }
  }
}

/// From where a point was measured to where it is [m].
Eigen::Vector2d moved(const ScanPoint& point) {
  return point.moved == 0.0
             ? Eigen::Vector2d::Zero()
             : Eigen::Vector2d(point.moved * (point.position - point.origin).normalized());
}

/// Counts the points at each surface.
class SurfaceCounts {
 public:
  explicit SurfaceCounts(std::size_t points) { entries_.reserve(points); }

  /// Counts a point and returns the number of its surface's entry. Neighbouring points lie next to
  /// few surfaces, between which noise makes them jump, so the latest ones are looked through.
  std::size_t add(const Eigen::Vector2d& surface) {
    constexpr std::size_t kLatest = 8;
    const std::size_t first = entries_.size() - std::min(kLatest, entries_.size());
    for (std::size_t i = entries_.size(); i > first; --i) {
      if (Entry& entry = entries_[i - 1]; entry.x == surface.x() && entry.y == surface.y()) {
        entry.points += 1.0;
        return i - 1;
      }
    }
    entries_.push_back({surface.x(), surface.y(), 1.0});
    return entries_.size() - 1;
  }

  [[nodiscard]] double points(std::size_t number) const { return entries_[number].points; }

 private:
  struct Entry {
    double x, y;  ///< where the surface is
    double points;
  };
  std::vector<Entry> entries_;
};

}  // namespace

Correspondences::Correspondences(const std::vector<ScanPoint>& points, const PlacedFields& fields,
                                 const Pose2& map_from_base)
    : fields_(fields.begin(), fields.end()) {
  points_.reserve(points.size());
  for (const ScanPoint& point : points) {
    // What is no number would make the whole sum none.
    if (point.position.allFinite() && std::isfinite(point.weight)) {
      total_weight_ += point.weight;
      points_.emplace_back();
      points_.back().position = point.position;
      points_.back().moved = moved(point);
      points_.back().weight = point.weight;
    }
  }
  const std::size_t padded = (points.size() + kLanes - 1) / kLanes * kLanes;
  for (auto* array :
       {&arrays_.rotated_x, &arrays_.rotated_y, &arrays_.offset_x, &arrays_.offset_y, &arrays_.c,
        &arrays_.s, &arrays_.weight, &arrays_.variance, &arrays_.information}) {
    array->resize(padded, 0.0);
  }
  move_to(map_from_base);
}

Correspondences::TurnedField::TurnedField(const PlacedField& placed)
    : field(placed.field),
      origin(placed.map_from_field.translation()),
      cosine(std::cos(placed.map_from_field.theta)),
      sine(std::sin(placed.map_from_field.theta)) {}

inline Cell Correspondences::TurnedField::cell_at(const Eigen::Vector2d& map_position) const {
  const Eigen::Vector2d from_origin = map_position - origin;
  return field->geometry().cell_at({cosine * from_origin.x() + sine * from_origin.y(),
                                    cosine * from_origin.y() - sine * from_origin.x()});
}

Surface Correspondences::TurnedField::to_map(const Surface& surface) const {
  const auto turned = [](double c, double s, const Eigen::Vector2d& vector) {
    return Eigen::Vector2d(c * vector.x() - s * vector.y(), s * vector.x() + c * vector.y());
  };
  return {origin + turned(cosine, sine, surface.position),
          turned(cosine * cosine - sine * sine, 2.0 * cosine * sine, surface.double_angle),
          surface.hits};
}

/// Gives the point the surface next to a cell. Whether it is another one than before.
bool Correspondences::take_surface(std::size_t field, const Cell& cell, Point& point) const {
  const bool was_same_field = point.field == field;
  point.field = field;
  point.cell = cell;
  Surface surface;
  const bool had_surface =
      std::exchange(point.has_surface, fields_[field].field->nearest_surface(cell, surface));
  if (!point.has_surface) {
    return had_surface;
  }
  const Eigen::Vector2d before = point.surface.position;
  point.surface = fields_[field].to_map(surface);
  if (had_surface && was_same_field && before == point.surface.position) {
    return false;
  }
  const double bluntness = 1.0 - std::min(1.0, point.surface.double_angle.norm());
  point.own = 1.0 + kBluntness * bluntness;
  point.common = 1.0 / point.surface.hits + kSurfaceError;
  return true;
}

/// Finds the nearest of the surfaces next to a point. Whether it is another one than before.
inline bool Correspondences::look_up(const Eigen::Vector2d& position, Point& point) const {
  if (fields_.size() == 1) {  // it need not be compared
    const Cell cell = fields_.front().cell_at(position);
    return (point.field != 0 || cell != point.cell) && take_surface(0, cell, point);
  }
  std::size_t nearest = fields_.size();
  Cell cell;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const LikelihoodField& field = *fields_[i].field;
    const Cell here = fields_[i].cell_at(position);
    const std::uint8_t steps = field.distance(here);
    const double distance = field.options().reach * steps;
    if (steps != LikelihoodField::kFar && distance < least) {
      nearest = i;
      cell = here;
      least = distance;
    }
  }
  if (nearest == fields_.size()) {
    point.field = nearest;
    return std::exchange(point.has_surface, false);
  }
  return (nearest != point.field || cell != point.cell) && take_surface(nearest, cell, point);
}

void Correspondences::move_to(const Pose2& map_from_base) {
  cosine_ = std::cos(map_from_base.theta);
  sine_ = std::sin(map_from_base.theta);
  bool is_weighed = true;
  std::size_t count = 0;
  for (Point& point : points_) {
    const Eigen::Vector2d rotated(cosine_ * point.position.x() - sine_ * point.position.y(),
                                  sine_ * point.position.x() + cosine_ * point.position.y());
    const Eigen::Vector2d position = rotated + map_from_base.translation();
    if (look_up(position, point)) {
      is_weighed = false;
    }
    if (point.has_surface) {
      arrays_.rotated_x[count] = rotated.x();
      arrays_.rotated_y[count] = rotated.y();
      arrays_.offset_x[count] = position.x() - point.surface.position.x();
      arrays_.offset_y[count] = position.y() - point.surface.position.y();
      ++count;
    }
  }
  if (!is_weighed) {
    weigh();
  }
}

/// What hangs on the points' surfaces alone, and not on where the points lie.
void Correspondences::weigh() {
  SurfaceCounts surfaces(points_.size());
  std::vector<std::size_t> surface_of;
  surface_of.reserve(points_.size());
  for (const Point& point : points_) {
    if (point.has_surface) {
      surface_of.push_back(surfaces.add(point.surface.position));
    }
  }
  std::size_t count = 0;
  for (const Point& point : points_) {
    if (point.has_surface) {
      arrays_.c[count] = point.surface.double_angle.x();
      arrays_.s[count] = point.surface.double_angle.y();
      arrays_.weight[count] = point.weight;
      arrays_.variance[count] = point.own + point.common;
      arrays_.information[count] =
          1.0 / (point.own + surfaces.points(surface_of[count]) * point.common);
      ++count;
    }
  }
  const auto rest = static_cast<std::ptrdiff_t>(count);
  std::fill(arrays_.weight.begin() + rest, arrays_.weight.end(), 0.0);
  std::fill(arrays_.information.begin() + rest, arrays_.information.end(), 0.0);
}

NormalEquations Correspondences::linearise(double kernel) const {
  LaneSums<9> lanes{};
  add_normal_equations(view_of(arrays_), kernel * kernel, lanes.data());
  const auto sum = [&lanes](std::size_t which) { return sum_of(&lanes[which * kLanes]); };
  NormalEquations equations;
  equations.information << sum(0), sum(1), sum(2),  //
      sum(1), sum(3), sum(4),                       //
      sum(2), sum(4), sum(5);
  equations.gradient << sum(6), sum(7), sum(8);
  return equations;
}

double Correspondences::facing_information(double kernel, const Eigen::Vector3d& motion) const {
  // Of the surface's direction with the motion's, as double angles: within 18 degrees of it, and
  // nearer where the hits agree less.
  constexpr double kFacing = 0.8;
  const View view = view_of(arrays_);
  const double c = motion.x() * motion.x() - motion.y() * motion.y();
  const double s = 2.0 * motion.x() * motion.y();
  double sum = 0.0;
  for (std::size_t j = 0; j < view.size; ++j) {
    if (view.c[j] * c + view.s[j] * s > kFacing) {
      const double square = square_of(view, j, view.offset_x[j], view.offset_y[j]);
      const double closeness = kernel * kernel / (kernel * kernel + square);
      sum += view.information[j] * closeness * closeness *
             square_of(view, j, motion.x() - motion.z() * view.rotated_y[j],
                       motion.y() + motion.z() * view.rotated_x[j]);
    }
  }
  return sum;
}

double Correspondences::cost(double kernel, const Eigen::Vector3d& step) const {
  LaneSums<2> lanes{};
  add_closeness(view_of(arrays_), kernel * kernel, step.x(), step.y(), step.z(), lanes.data());
  return sum_of(&lanes[kLanes]);
}

double Correspondences::closeness(double kernel, const Eigen::Vector3d& step) const {
  if (!(total_weight_ > 0.0)) {
    return 0.0;
  }
  LaneSums<2> lanes{};
  add_closeness(view_of(arrays_), kernel * kernel, step.x(), step.y(), step.z(), lanes.data());
  return sum_of(lanes.data()) / total_weight_;
}

ResidualSum Correspondences::residuals(double kernel) const {
  std::vector<double> moved_x(arrays_.weight.size());
  std::vector<double> moved_y(arrays_.weight.size());
  std::size_t count = 0;
  for (const Point& point : points_) {
    if (point.has_surface) {
      moved_x[count] = cosine_ * point.moved.x() - sine_ * point.moved.y();
      moved_y[count] = sine_ * point.moved.x() + cosine_ * point.moved.y();
      ++count;
    }
  }
  LaneSums<2> lanes{};
  add_variance(view_of(arrays_), moved_x.data(), moved_y.data(), kernel * kernel, lanes.data());
  return {sum_of(lanes.data()), sum_of(&lanes[kLanes])};
}

}  // namespace matchbox_slam
