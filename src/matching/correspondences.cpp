#include "matchbox_slam/matching/correspondences.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "matching/point_rows.hpp"

namespace matchbox_slam {
namespace {

// Variance of a surface's error that no number of hits averages out, in units of a point's: its
// direction comes from neighbours that share their errors. Half or double of it changes the mean
// NEES of pairs by +5 and -5 %, the median error by up to 2 %.
constexpr double kSurfaceError = 0.25;

// Variance, in the same units and on top of the point's, of the distance to a surface without a
// direction: that of two places anywhere in one cell of 5 cm, 2 (5 cm)^2 / 12, with the default
// noise of 1 cm. Half or double of it changes the median error of pairs by up to 2 %.
constexpr double kPointSurfaceVariance = 4.0;

// Variance, likewise, where the scan shows a wall across the one that the map has nearby: the point
// is not on that one. In corridors a far hit of the side wall lies in the corner where a cupboard
// or a door stands out; taken for its front it tells, always from the same beam, that the robot
// stands still. 48 drives through hotels and campuses: mean error 0.085 m, and 0.13 without it; 40
// is as good.
constexpr double kCrossWallVariance = 200.0;

/// From where a point was measured to where it is [m].
Eigen::Vector2d moved(const ScanPoint& point) {
  return point.moved == 0.0
             ? Eigen::Vector2d::Zero()
             : Eigen::Vector2d(point.moved * (point.position - point.origin).normalized());
}

/// Variance of where a point lies on a surface of unknown direction, over that within a cell, less
/// that itself.
double sparseness(const ScanPoint& point) {
  const double share = known_share(point);
  return 1.0 / (share * share) - 1.0;
}

/// Of a place's numbers.
std::uint64_t hash_of(double x, double y) {
  std::uint64_t x_bits = 0;
  std::uint64_t y_bits = 0;
  std::memcpy(&x_bits, &x, sizeof(x));
  std::memcpy(&y_bits, &y, sizeof(y));
  return ((x_bits * 0x9E3779B97F4A7C15U) ^ y_bits) * 0xC2B2AE3D27D4EB4FU;
}

std::size_t power_of_two_from(std::size_t least) {
  std::size_t power = 1;
  while (power < least) {
    power *= 2;
  }
  return power;
}

}  // namespace

void Correspondences::assign(const std::vector<ScanPoint>& points, const PlacedField* fields,
                             std::size_t count, const Pose2& map_from_base) {
  count_ = 0;
  blocks_ = points.size() / Block().size() + 1;
  const std::size_t padded = blocks_ * Block().size();
  numbers_.resize(kRows * blocks_);
  total_weight_ = 0.0;
  for (const ScanPoint& point : points) {
    // What is no number would make the whole sum none.
    if (point.position.allFinite() && std::isfinite(point.weight)) {
      const Eigen::Vector2d from_measured = moved(point);
      row(kX)[count_] = point.position.x();
      row(kY)[count_] = point.position.y();
      row(kMovedX)[count_] = from_measured.x();
      row(kMovedY)[count_] = from_measured.y();
      row(kWall)[count_] = point.weight;
      const Eigen::Vector2d& normal = point.normal;
      row(kNormalC)[count_] = normal.x() * normal.x() - normal.y() * normal.y();
      row(kNormalS)[count_] = 2.0 * normal.x() * normal.y();
      row(kSpacing)[count_] = sparseness(point);
      total_weight_ += point.weight;
      ++count_;
    }
  }
  for (const Row of_point : {kX, kY, kMovedX, kMovedY, kWall, kNormalC, kNormalS, kSpacing}) {
    std::fill(row(of_point) + count_, row(of_point) + padded, 0.0);
  }
  std::fill_n(row(kPresent), kSurfaceRows * padded, 0.0);
  for (const Row by_surface : {kC, kS, kOwn}) {
    std::fill_n(row(by_surface), padded, 0.0);
  }
  std::fill_n(row(kInformation), padded, 0.0);
  fields_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::min();
    const Pose2& pose = fields[i].map_from_field;
    TurnedField& turned = fields_[i];
    turned.field = fields[i].field;
    turned.origin = pose.translation();
    turned.cosine = std::cos(pose.theta);
    turned.sine = std::sin(pose.theta);
    turned.cell_x.assign(padded, kNone);
    turned.cell_y.assign(padded, kNone);
  }
  moved_.resize(padded);
  group_of_.assign(padded, 0);
  points_in_.resize(padded + 1);
  table_.resize(power_of_two_from(2 * count_ + 1));
  move_to(map_from_base);
}

PointRows Correspondences::rows() const {
  return {blocks_ * Block().size(),
          row(kRotatedX),
          row(kRotatedY),
          row(kOffsetX),
          row(kOffsetY),
          row(kC),
          row(kS),
          row(kWall),
          row(kPresent),
          row(kOwn),
          row(kCommon),
          row(kInformation)};
}

/// Whether a point lies in the same cells as the one before, and so next to the same surface.
bool Correspondences::is_with_the_one_before(std::size_t point) const {
  return point > 0 &&
         std::all_of(fields_.begin(), fields_.end(), [point](const TurnedField& field) {
           return field.cell_of(point) == field.cell_of(point - 1);
         });
}

/// The nearest of the surfaces next to a point.
Correspondences::SurfaceNumbers Correspondences::nearest_surface(std::size_t point) const {
  const TurnedField* nearest = fields_.data();
  if (fields_.size() > 1) {
    nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const TurnedField& field : fields_) {
      const std::uint8_t steps = field.field->distance(field.cell_of(point));
      const double distance = field.field->options().reach * steps;
      if (steps != LikelihoodField::kFar && distance < least) {
        nearest = &field;
        least = distance;
      }
    }
  }
  Surface surface;
  if (nearest == nullptr || !nearest->field->nearest_surface(nearest->cell_of(point), surface)) {
    return {};
  }
  const auto turned = [](double c, double s, const Eigen::Vector2d& vector) {
    return Eigen::Vector2d(c * vector.x() - s * vector.y(), s * vector.x() + c * vector.y());
  };
  const double c = nearest->cosine;
  const double s = nearest->sine;
  const Eigen::Vector2d position = nearest->origin + turned(c, s, surface.position);
  const Eigen::Vector2d direction = turned(c * c - s * s, 2.0 * c * s, surface.double_angle);
  const double bluntness = 1.0 - std::min(1.0, direction.norm());
  return {1.0,
          position.x(),
          position.y(),
          direction.x(),
          direction.y(),
          1.0 + kPointSurfaceVariance * bluntness,
          1.0 / surface.hits + kSurfaceError};
}

void Correspondences::move_to(const Pose2& map_from_base) {
  cosine_ = std::cos(map_from_base.theta);
  sine_ = std::sin(map_from_base.theta);
  const std::size_t size = blocks_ * Block().size();
  rotate(row(kX), row(kY), size, cosine_, sine_, row(kRotatedX), row(kRotatedY));
  std::fill(moved_.begin(), moved_.end(), 0);
  for (TurnedField& field : fields_) {
    find_cells(row(kRotatedX), row(kRotatedY), size, map_from_base,
               {field.origin.x(), field.origin.y(), 0.0}, field.cosine, field.sine,
               field.field->geometry().resolution(), field.cell_x.data(), field.cell_y.data(),
               moved_.data());
  }
  const bool are_turned = turn_normals(map_from_base.theta);
  const bool is_weighed = find_surfaces() && !are_turned;
  for (std::size_t i = 0; i < count_; ++i) {
    if (are_turned || moved_[i] != 0) {
      find_own(i);
    }
  }
  find_offsets(row(kPresent), row(kSurfaceX), row(kSurfaceY), size, map_from_base.x,
               map_from_base.y, row(kRotatedX), row(kRotatedY), row(kOffsetX), row(kOffsetY));
  if (!is_weighed) {
    weigh();
  }
}

/// Of the points that came into another cell. Whether all are as they were.
bool Correspondences::find_surfaces() {
  const std::size_t stride = blocks_ * Block().size();
  bool is_as_before = true;
  for (std::size_t i = 0; i < count_; ++i) {
    if (moved_[i] != 0) {
      double* number = row(kPresent) + i;
      SurfaceNumbers surface;
      if (is_with_the_one_before(i)) {
        for (std::size_t k = 0; k < kSurfaceRows; ++k) {
          surface[k] = number[k * stride - 1];
        }
      } else {
        surface = nearest_surface(i);
      }
      for (std::size_t k = 0; k < kSurfaceRows; ++k) {
        is_as_before = is_as_before && number[k * stride] == surface[k];
        number[k * stride] = surface[k];
      }
    }
  }
  return is_as_before;
}

/// In steps, so that most moves leave them as they are. Whether this one does not.
bool Correspondences::turn_normals(double heading) {
  constexpr double kStep = 1.0 / 64.0;  // [rad], of no account beside the directions' own errors
  const double coarse = kStep * std::round(heading / kStep);
  if (coarse == coarse_heading_) {
    return false;
  }
  coarse_heading_ = coarse;
  double_turn_ = {std::cos(2.0 * coarse), std::sin(2.0 * coarse)};
  return true;
}

void Correspondences::find_own(std::size_t point) {
  const double normal_c =
      double_turn_.x() * row(kNormalC)[point] - double_turn_.y() * row(kNormalS)[point];
  const double normal_s =
      double_turn_.y() * row(kNormalC)[point] + double_turn_.x() * row(kNormalS)[point];
  const double c = row(kSurfaceC)[point];
  const double s = row(kSurfaceS)[point];
  const double agreement = normal_c * c + normal_s * s;
  // What the map does not know of the surface's direction the scan may.
  const double unknown = row(kPresent)[point] * (1.0 - std::min(1.0, std::sqrt(c * c + s * s)));
  row(kC)[point] = c + unknown * normal_c;
  row(kS)[point] = s + unknown * normal_s;
  const double blunt = row(kBlunt)[point];
  row(kOwn)[point] = blunt + row(kSpacing)[point] * std::max(0.0, blunt - 1.0) +
                     kCrossWallVariance * std::max(0.0, -agreement);
}

/// What hangs on the points' surfaces alone, and not on where the points lie: how many points there
/// are at each. Neighbouring points lie next to few surfaces, between which noise makes them jump;
/// one that comes back later than that begins another group. With all points at a surface in one
/// group the error of aces is 7 % larger, that of belgioioso 2 %, and that of rooms 2 % smaller.
void Correspondences::weigh() {
  constexpr std::int32_t kLatest = 8;
  constexpr std::int32_t kNone = -1;
  std::fill(table_.begin(), table_.end(), kNone);
  const double* present = row(kPresent);
  const double* x = row(kSurfaceX);
  const double* y = row(kSurfaceY);
  const std::size_t mask = table_.size() - 1;
  std::int32_t groups = 0;
  for (std::size_t i = 0; i < count_;) {
    const auto is_at = [&](std::size_t other) { return x[other] == x[i] && y[other] == y[i]; };
    std::size_t end = i + 1;
    if (present[i] > 0.0) {
      while (end < count_ && present[end] > 0.0 && is_at(end)) {
        ++end;
      }
      std::size_t slot = (hash_of(x[i], y[i]) >> 32U) & mask;
      while (table_[slot] != kNone && !is_at(static_cast<std::size_t>(table_[slot]))) {
        slot = (slot + 1) & mask;
      }
      const std::int32_t before = table_[slot];
      table_[slot] = static_cast<std::int32_t>(i);
      std::int32_t group = before == kNone ? kNone : group_of_[static_cast<std::size_t>(before)];
      if (group == kNone || group < groups - kLatest) {
        group = groups++;
        points_in_[static_cast<std::size_t>(group)] = 0.0;
      }
      std::fill(&group_of_[i], &group_of_[i] + (end - i), group);
      points_in_[static_cast<std::size_t>(group)] += static_cast<double>(end - i);
    }
    i = end;
  }
  find_information(present, row(kOwn), row(kCommon), group_of_.data(), points_in_.data(),
                   blocks_ * Block().size(), row(kInformation));
}

NormalEquations Correspondences::linearise(double kernel) const {
  LaneSums<9> lanes{};
  add_normal_equations(rows(), kernel * kernel, lanes.data());
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
  // nearer where the hits agree less. Half or double changes no byte of six drives with faults and
  // two logs (benchmark/reports/current/CONSTANTS.md).
  constexpr double kMinDoubledCosine = 0.8;
  const PointRows view = rows();
  const double c = motion.x() * motion.x() - motion.y() * motion.y();
  const double s = 2.0 * motion.x() * motion.y();
  double sum = 0.0;
  for (std::size_t j = 0; j < view.size; ++j) {
    if (view.c[j] * c + view.s[j] * s > kMinDoubledCosine) {
      const double square = square_of(view, j, view.offset_x[j], view.offset_y[j]);
      const double closeness = kernel * kernel / (kernel * kernel + square);
      sum += view.information[j] * closeness * closeness *
             square_of(view, j, motion.x() - motion.z() * view.rotated_y[j],
                       motion.y() + motion.z() * view.rotated_x[j]);
    }
  }
  return sum;
}

double Correspondences::confirmed_information(double kernel, const Eigen::Vector3d& motion) const {
  const PointRows view = rows();
  double sum = 0.0;
  for (std::size_t j = 0; j < view.size; ++j) {
    const double x = motion.x() - motion.z() * view.rotated_y[j];
    const double y = motion.y() + motion.z() * view.rotated_x[j];
    const double square = square_of(view, j, view.offset_x[j], view.offset_y[j]);
    const double closeness = kernel * kernel / (kernel * kernel + square);
    const double map_c = row(kSurfaceC)[j];
    const double map_s = row(kSurfaceS)[j];
    const double own_c = double_turn_.x() * row(kNormalC)[j] - double_turn_.y() * row(kNormalS)[j];
    const double own_s = double_turn_.y() * row(kNormalC)[j] + double_turn_.x() * row(kNormalS)[j];
    const double both = 1.0 + map_c * own_c + map_s * own_s;
    sum += view.information[j] * closeness * closeness * 0.25 *
           (both * (x * x + y * y) + (map_c + own_c) * (x * x - y * y) +
            2.0 * (map_s + own_s) * x * y);
  }
  return sum;
}

double Correspondences::cost(double kernel, const Eigen::Vector3d& step) const {
  LaneSums<2> lanes{};
  add_closeness(rows(), kernel * kernel, step.x(), step.y(), step.z(), lanes.data());
  return sum_of(&lanes[kLanes]);
}

double Correspondences::closeness(double kernel, const Eigen::Vector3d& step) const {
  if (!(total_weight_ > 0.0)) {
    return 0.0;
  }
  LaneSums<2> lanes{};
  add_closeness(rows(), kernel * kernel, step.x(), step.y(), step.z(), lanes.data());
  return sum_of(lanes.data()) / total_weight_;
}

void Correspondences::costs_of_both(double kernel, const std::vector<Eigen::Vector3d>& steps,
                                    std::vector<std::array<double, 2>>& costs) const {
  constexpr std::size_t kBatchSize = 64;
  costs.resize(steps.size());
  for (std::size_t first = 0; first < steps.size(); first += kBatchSize) {
    const std::size_t count = std::min(kBatchSize, steps.size() - first);
    std::array<float, 3 * kBatchSize> numbers;
    for (std::size_t i = 0; i < count; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        numbers[3 * i + static_cast<std::size_t>(axis)] =
            static_cast<float>(steps[first + i](axis));
      }
    }
    std::array<float, 2 * kFloatLanes * kBatchSize> lanes;
    std::fill_n(lanes.begin(), 2 * kFloatLanes * count, 0.0F);
    add_costs_of_both(rows(), static_cast<float>(kernel * kernel), numbers.data(), count,
                      lanes.data());
    const float* lane = lanes.data();
    for (std::size_t i = first; i < first + count; ++i) {
      for (double& cost : costs[i]) {
        cost = std::accumulate(lane, lane + kFloatLanes, 0.0);
        lane += kFloatLanes;
      }
    }
  }
}

ResidualSum Correspondences::residuals(double kernel) const {
  LaneSums<2> lanes{};
  add_variance(rows(), row(kMovedX), row(kMovedY), cosine_, sine_, kernel * kernel, lanes.data());
  return {sum_of(lanes.data()), sum_of(&lanes[kLanes])};
}

}  // namespace matchbox_slam
