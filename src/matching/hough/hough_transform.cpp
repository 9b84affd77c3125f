#include "matchbox_slam/matching/hough/hough_transform.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "common/simd.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matching/hough/lane_dot.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kRowLanes = 16;  // of a loop that the compiler vectorises

/// Positions of the points in a column, in cells from its first one.
MATCHBOX_SIMD_CLONES void locate(const float* __restrict__ x, const float* __restrict__ y,
                                 std::size_t count, float cosine, float sine, float origin,
                                 std::int32_t* __restrict__ cell, float* __restrict__ share) {
  for (std::size_t i = 0; i < count; ++i) {
    const float position = x[i] * cosine + y[i] * sine + origin;
    const auto below = static_cast<std::int32_t>(position);  // positive, so this rounds down
    cell[i] = below;
    share[i] = position - static_cast<float>(below);
  }
}

MATCHBOX_SIMD_CLONES void take_maxima(const float* __restrict__ values, std::size_t count,
                                      float* __restrict__ lanes) {
  for (std::size_t i = 0; i + kRowLanes <= count; i += kRowLanes) {
    for (std::size_t k = 0; k < kRowLanes; ++k) {
      lanes[k] = lanes[k] < values[i + k] ? values[i + k] : lanes[k];
    }
  }
}

std::size_t padded(std::size_t count) { return (count + kRowLanes - 1) / kRowLanes * kRowLanes; }

/// Buffers for one column after another.
class ColumnMaker {
 public:
  ColumnMaker(const HoughPoints& points, double rho_cell, int half_cells)
      : points_(points),
        inverse_cell_(1.0 / rho_cell),
        half_cells_(half_cells),
        cell_(points.size()),
        share_(points.size()),
        column_(padded(2 * static_cast<std::size_t>(half_cells) + 1)) {}

  /// Zeros follow the last cell up to a whole number of lanes.
  const std::vector<float>& make(double theta) {
    std::fill(column_.begin(), column_.end(), 0.0F);
    locate(points_.x.data(), points_.y.data(), points_.size(),
           static_cast<float>(std::cos(theta) * inverse_cell_),
           static_cast<float>(std::sin(theta) * inverse_cell_), static_cast<float>(half_cells_),
           cell_.data(), share_.data());
    float* column = column_.data();
    const float* weight = points_.weight.data();
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count; ++i) {
      const float above = weight[i] * share_[i];
      column[cell_[i]] += weight[i] - above;
      column[cell_[i] + 1] += above;
    }
    return column_;
  }

 private:
  const HoughPoints& points_;
  double inverse_cell_;
  int half_cells_;
  std::vector<std::int32_t> cell_;
  std::vector<float> share_;
  std::vector<float> column_;
};

float spectrum_of(const std::vector<float>& column, SpectrumKind kind) {
  if (kind == SpectrumKind::kEnergy) {
    return lane_dot(column.data(), column.data(), column.size());
  }
  std::array<float, kRowLanes> lanes{};
  take_maxima(column.data(), column.size(), lanes.data());
  return *std::max_element(lanes.begin(), lanes.end());
}

/// Lengths of wall that points stand for, 0 for those between two jumps.
class WallLengths {
 public:
  explicit WallLengths(const std::vector<ScanPoint>& points) : points_(points) {}

  [[nodiscard]] float at(std::size_t i) const {
    const double before = i > 0 ? piece(i - 1) : 0.0;
    const double after = i + 1 < points_.size() ? piece(i) : 0.0;
    return static_cast<float>(0.5 * (before + after));
  }

 private:
  /// Of the wall from a point to the next.
  [[nodiscard]] double piece(std::size_t i) const {
    // [m]; longer gaps are no wall, unless joined; half or double: intel 7 % worse.
    constexpr double kJump = 0.2;
    // [m] of wall between two points at most; with 0.15 hough loses its way in intel.
    constexpr double kMaxPiece = 0.3;
    const double gap = (points_[i + 1].position - points_[i].position).norm();
    if (!points_[i].joined_to_next && !(gap < kJump)) {
      return 0.0;
    }
    return std::min(gap, kMaxPiece);
  }

  const std::vector<ScanPoint>& points_;
};

/// Points that vote as one.
struct VotingGroup {
  Eigen::Vector2d first;
  Eigen::Vector2d moment;
  double weight;

  void add_to(HoughPoints& points) const {
    const Eigen::Vector2d mean = moment / weight;
    points.x.push_back(static_cast<float>(mean.x()));
    points.y.push_back(static_cast<float>(mean.y()));
    points.weight.push_back(static_cast<float>(weight));
    points.reach = std::max(points.reach, mean.norm());
  }
};

std::vector<float> without_mean(const std::vector<float>& values) {
  float sum = 0.0F;
  for (const float value : values) {
    sum += value;
  }
  const float mean = sum / static_cast<float>(values.size());
  std::vector<float> centered(values);
  for (float& value : centered) {
    value -= mean;
  }
  return centered;
}

}  // namespace

double HoughGrid::angle(double column) const { return column * kPi / angles; }

HoughPoints hough_points(const std::vector<ScanPoint>& points, double spacing) {
  std::vector<ScanPoint> usable;
  usable.reserve(points.size());
  for (const ScanPoint& point : points) {
    if (point.position.norm() < kFarthestPoint) {
      usable.push_back(point);
    }
  }
  HoughPoints result;
  const WallLengths lengths(usable);
  VotingGroup group{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), 0.0};
  for (std::size_t i = 0; i < usable.size(); ++i) {
    const double weight = lengths.at(i);
    if (!(weight > 0.0)) {
      continue;
    }
    const Eigen::Vector2d& position = usable[i].position;
    if (group.weight > 0.0 && !((position - group.first).norm() < spacing)) {
      group.add_to(result);
      group.weight = 0.0;
    }
    if (!(group.weight > 0.0)) {
      group = {position, weight * position, weight};
    } else {
      group.moment += weight * position;
      group.weight += weight;
    }
  }
  if (group.weight > 0.0) {
    group.add_to(result);
  }
  return result;
}

int hough_half_cells(const HoughPoints& points, double rho_cell) {
  return static_cast<int>(std::ceil(points.reach / rho_cell)) + 2;
}

std::vector<float> hough_column(const HoughPoints& points, double theta, double rho_cell,
                                int half_cells) {
  std::vector<float> column = ColumnMaker(points, rho_cell, half_cells).make(theta);
  column.resize(2 * static_cast<std::size_t>(half_cells) + 1);
  return column;
}

std::vector<float> hough_spectrum(const HoughPoints& points, const HoughGrid& grid,
                                  SpectrumKind kind) {
  ColumnMaker columns(points, grid.rho_cell, hough_half_cells(points, grid.rho_cell));
  std::vector<float> spectrum;
  spectrum.reserve(static_cast<std::size_t>(grid.angles));
  for (int k = 0; k < grid.angles; ++k) {
    spectrum.push_back(spectrum_of(columns.make(grid.angle(k)), kind));
  }
  return spectrum;
}

std::vector<float> correlate_spectra(const std::vector<float>& reference,
                                     const std::vector<float>& scan) {
  const std::size_t count = reference.size();
  const std::vector<float> a = without_mean(reference);
  std::vector<float> b = without_mean(scan);
  const float scale =
      std::sqrt(lane_dot(a.data(), a.data(), count) * lane_dot(b.data(), b.data(), count));
  b.insert(b.end(), b.begin(), b.end());
  std::vector<float> correlation(count, 0.0F);
  for (std::size_t k = 0; scale > 0.0F && k < count; ++k) {
    // reference(i) = scan(i - k)
    correlation[k] = lane_dot(a.data(), b.data() + (count - k), count) / scale;
  }
  return correlation;
}

}  // namespace matchbox_slam
