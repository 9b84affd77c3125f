#include "simulation/segment_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

// Small enough that few segments share a cell, large enough that a ray crosses few empty ones.
constexpr double kCellSize = 0.5;
// Bounds the memory of worlds of a few segments that lie far apart.
constexpr double kMaxCellsPerSide = 1000.0;
// A segment also belongs to the cells that it misses by rounding.
constexpr double kMargin = 1e-6;
constexpr double kEndless = std::numeric_limits<double>::infinity();

struct Interval {
  double from;
  double to;
};

/// Part of the ray, by range, whose coordinate on one axis lies between low and high.
Interval clip(double origin, double direction, double low, double high) {
  if (direction == 0.0) {
    return origin >= low && origin <= high ? Interval{0.0, kEndless} : Interval{kEndless, 0.0};
  }
  const double a = (low - origin) / direction;
  const double b = (high - origin) / direction;
  return {std::min(a, b), std::max(a, b)};
}

/// The walk of a ray along one axis of the grid.
struct AxisWalk {
  /// Range at which the ray leaves the cell, from the cell's number so that no rounding adds up.
  [[nodiscard]] double exit_range() const {
    if (direction == 0.0) {
      return kEndless;
    }
    return (low + (cell + (step() > 0 ? 1 : 0)) * cell_size - origin) / direction;
  }

  [[nodiscard]] int step() const { return direction > 0.0 ? 1 : -1; }

  double origin;
  double direction;
  double low;
  double cell_size;
  int cell;
};

}  // namespace

SegmentGrid::SegmentGrid(const std::vector<WallSegment>& segments) {
  if (segments.empty()) {
    return;
  }
  low_ = segments.front().start;
  high_ = low_;
  for (const WallSegment& segment : segments) {
    low_ = low_.cwiseMin(segment.start).cwiseMin(segment.end);
    high_ = high_.cwiseMax(segment.start).cwiseMax(segment.end);
  }
  low_.array() -= kMargin;
  high_.array() += kMargin;
  const Eigen::Vector2d extent = high_ - low_;
  cell_size_ = std::max(kCellSize, extent.maxCoeff() / kMaxCellsPerSide);
  columns_ = static_cast<int>(std::ceil(extent.x() / cell_size_));
  rows_ = static_cast<int>(std::ceil(extent.y() / cell_size_));

  std::vector<std::vector<std::size_t>> cells(static_cast<std::size_t>(columns_) *
                                              static_cast<std::size_t>(rows_));
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (segments[i].surface.walk) {
      continue;
    }
    const Eigen::Vector2d from = segments[i].start.cwiseMin(segments[i].end).array() - kMargin;
    const Eigen::Vector2d to = segments[i].start.cwiseMax(segments[i].end).array() + kMargin;
    for (int row = cell_of(from.y(), low_.y(), rows_); row <= cell_of(to.y(), low_.y(), rows_);
         ++row) {
      for (int column = cell_of(from.x(), low_.x(), columns_);
           column <= cell_of(to.x(), low_.x(), columns_); ++column) {
        if (touches(segments[i], column, row)) {
          cells[index_of(column, row)].push_back(i);
        }
      }
    }
  }
  first_in_cell_.reserve(cells.size() + 1);
  for (const std::vector<std::size_t>& cell : cells) {
    first_in_cell_.push_back(in_cells_.size());
    in_cells_.insert(in_cells_.end(), cell.begin(), cell.end());
  }
  first_in_cell_.push_back(in_cells_.size());
}

std::size_t SegmentGrid::index_of(int column, int row) const {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(column);
}

int SegmentGrid::cell_of(double coordinate, double low, int cells) const {
  return std::clamp(static_cast<int>(std::floor((coordinate - low) / cell_size_)), 0, cells - 1);
}

bool SegmentGrid::touches(const WallSegment& segment, int column, int row) const {
  // The segment's bounding box meets the cell; its line does when the cell's corners are not all on
  // one side of it.
  const Eigen::Vector2d centre = low_ + cell_size_ * Eigen::Vector2d(column + 0.5, row + 0.5);
  const Eigen::Vector2d normal = segment.normal();
  const double reach = 0.5 * cell_size_ * normal.cwiseAbs().sum() + kMargin;
  return std::abs(normal.dot(centre - segment.start)) <= reach;
}

std::optional<SegmentGrid::Hit> SegmentGrid::first_hit(const std::vector<WallSegment>& segments,
                                                       const Eigen::Vector2d& origin,
                                                       const Eigen::Vector2d& direction,
                                                       double max_range, const RayPart& at_tables,
                                                       std::uint64_t chance) const {
  const Interval in_x = clip(origin.x(), direction.x(), low_.x(), high_.x());
  const Interval in_y = clip(origin.y(), direction.y(), low_.y(), high_.y());
  const double enter = std::max({0.0, in_x.from, in_y.from});
  const double leave = std::min({max_range, in_x.to, in_y.to});
  if (columns_ == 0 || !(enter <= leave)) {
    return std::nullopt;
  }
  const Eigen::Vector2d start = origin + enter * direction;
  AxisWalk x{origin.x(), direction.x(), low_.x(), cell_size_,
             cell_of(start.x(), low_.x(), columns_)};
  AxisWalk y{origin.y(), direction.y(), low_.y(), cell_size_, cell_of(start.y(), low_.y(), rows_)};

  std::optional<Hit> best;
  while (x.cell >= 0 && x.cell < columns_ && y.cell >= 0 && y.cell < rows_) {
    const std::size_t cell = index_of(x.cell, y.cell);
    for (std::size_t k = first_in_cell_[cell]; k < first_in_cell_[cell + 1]; ++k) {
      const std::size_t i = in_cells_[k];
      const std::optional<double> range = intersect_ray(segments[i], origin, direction);
      if (range && segments[i].is_table && !(*range >= at_tables.from && *range <= at_tables.to)) {
        continue;
      }
      if (range && *range <= max_range &&
          (!best || *range < best->range || (*range == best->range && i < best->segment)) &&
          !lets_pass(segments[i], direction, mix_seed(chance, i))) {
        best = Hit{*range, i};
      }
    }
    // A segment is found in the first of its cells, but may be hit in a later one, behind another.
    const double exit = std::min(x.exit_range(), y.exit_range());
    if ((best && best->range < exit - kMargin) || exit > leave + kMargin) {
      break;
    }
    AxisWalk& axis = x.exit_range() <= y.exit_range() ? x : y;
    axis.cell += axis.step();
  }
  return best;
}

}  // namespace matchbox_slam
