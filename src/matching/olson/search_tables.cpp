#include "matching/olson/search_tables.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace matchbox_slam {
namespace {

constexpr int kNoGroup = std::numeric_limits<int>::min();  // nor a rotation, which may be negative

CellBox grown(const CellBox& box, int by) {
  return {{box.min.x - by, box.min.y - by}, {box.max.x + by, box.max.y + by}};
}

/// Cells for which the field has tiles.
CellBox cells_of(const LikelihoodField& field) {
  constexpr int kSize = LikelihoodField::Tiles::kTileSize;
  const CellBox tiles = field.tiles().tile_bounds();
  return {{tiles.min.x * kSize, tiles.min.y * kSize}, {tiles.max.x * kSize, tiles.max.y * kSize}};
}

}  // namespace

/// Cells that points may fall into at any pose of a lattice.
class SearchTables::Reach {
 public:
  Reach(const SearchLattice& lattice, const GridGeometry& geometry)
      : turn_(std::min(kPi, lattice.step_theta * lattice.half_theta)),
        shift_(lattice.step_xy(geometry.resolution()) * lattice.half_xy),
        cosine_(std::cos(lattice.center.theta)),
        sine_(std::sin(lattice.center.theta)),
        center_(lattice.center.translation()),
        geometry_(geometry) {}

  /// From where to where a point gets by turning, relative to the center [m].
  struct Box {
    Eigen::Array2d low = Eigen::Array2d::Zero();
    Eigen::Array2d high = Eigen::Array2d::Zero();
  };

  [[nodiscard]] Box turned(double x, double y) const {
    const double range = std::sqrt(x * x + y * y);
    // No farther than the arc that the point moves on, nor than its distance from the base.
    const double arc = range * turn_;
    const Eigen::Array2d at(cosine_ * x - sine_ * y, sine_ * x + cosine_ * y);
    return {(at - arc).max(-range), (at + arc).min(range)};
  }

  [[nodiscard]] CellBox cells(const Box& box) const {
    const Cell first = geometry_.cell_at(center_ + (box.low - shift_).matrix());
    const Cell last = geometry_.cell_at(center_ + (box.high + shift_).matrix());
    return {{first.x - 1, first.y - 1}, {last.x + 2, last.y + 2}};
  }

  [[nodiscard]] CellBox cells_of_all(const PointArrays& points) const {
    Box all;
    for (std::size_t i = 0; i < points.x.size(); ++i) {
      const Box one = turned(points.x[i], points.y[i]);
      all.low = all.low.min(one.low);
      all.high = all.high.max(one.high);
    }
    return cells(all);
  }

 private:
  double turn_;   ///< to each side [rad]
  double shift_;  ///< [m]
  double cosine_, sine_;
  Eigen::Vector2d center_;  ///< [m]
  GridGeometry geometry_;
};

void SearchTables::LocatedPoints::clear(std::size_t slots, std::size_t points) {
  groups.assign(slots, kNoGroup);
  offsets.make(slots * points);
  weights.make(slots * points);
}

void SearchTables::assign(const PointArrays& points, const LatticeBlocks& blocks,
                          const LikelihoodField& field,
                          const FieldWindow::Values& value_of_likelihood) {
  blocks_ = &blocks;
  useful_ = {};
  if (!is_in_range()) {
    return;
  }
  const SearchLattice& lattice = blocks.lattice();
  const int top = blocks.top();
  // From the cell of a point without offset, a look-up goes this far at most.
  const int farthest = lattice.half_xy / lattice.steps_per_cell + 2 +
                       LatticeBlocks::bounds_of(top).stride + LatticeBlocks::bounds_of(top).width();
  const Reach reach(lattice, field.geometry());
  // Twice: a point beyond that meets nothing with any offset.
  CellBox cells = intersection(grown(reach.cells_of_all(points), farthest),
                               grown(cells_of(field), 2 * farthest));
  const Cell center = field.geometry().cell_at(lattice.center.translation());
  cells = intersection(cells, grown({center, {center.x + 1, center.y + 1}}, kFarthestCells));
  useful_ = grown(cells, -farthest);
  if (useful_.empty()) {
    return;
  }
  likelihoods_.frame(cells);
  need_around(points, reach, farthest);
  likelihoods_.read(field, value_of_likelihood);
  likelihoods_.make_bounds(top, bounds_);
  constexpr int kMaxLocatedGroups = 256;  // groups of a level at a time, to bound the memory
  for (int level = 0; level <= top; ++level) {
    const int slots = std::min(kMaxLocatedGroups, blocks.last_group(level) + 1);
    located_[static_cast<std::size_t>(level)].clear(static_cast<std::size_t>(slots),
                                                    blocks.scan_of(level).points.x.size());
  }
  located_.front().classes.make(located_.front().groups.size() * points.x.size());
}

/// @param farthest  from a point's cell to any that it may meet.
void SearchTables::need_around(const PointArrays& points, const Reach& reach, int farthest) {
  constexpr int kCoveredCells = 4;  // cells: so near to the one before a point asks for hardly more
  const double near = kCoveredCells * blocks_->resolution();
  std::size_t asked = 0;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    const double x = points.x[i] - points.x[asked];
    const double y = points.y[i] - points.y[asked];
    if (i == 0 || x * x + y * y > near * near) {
      asked = i;
      likelihoods_.need(
          grown(reach.cells(reach.turned(points.x[i], points.y[i])), farthest + kCoveredCells + 1));
    }
  }
}

/// Whether steps from the map's origin are counted in 32 bits without overflow.
bool SearchTables::is_in_range() const {
  constexpr double kMaxSteps = 1 << 30;
  const double farthest_point = 1e5;  // [m], see SearchPoint
  const SearchLattice& lattice = blocks_->lattice();
  const double farthest = lattice.center.translation().cwiseAbs().maxCoeff() + farthest_point;
  return farthest / lattice.step_xy(blocks_->resolution()) < kMaxSteps;
}

/// @param theta  [steps]
/// @param shift  of all points, along both axes [cells].
void SearchTables::rotate(const PointArrays& points, double theta, double shift) {
  const SearchLattice& lattice = blocks_->lattice();
  const double resolution = blocks_->resolution();
  const double angle = lattice.center.theta + lattice.step_theta * theta;
  const Rotation rotation{std::cos(angle),
                          std::sin(angle),
                          lattice.center.x + shift * resolution,
                          lattice.center.y + shift * resolution,
                          lattice.steps_per_cell / resolution,
                          static_cast<double>(lattice.steps_per_cell)};
  rotate_points(points, rotation, rotated_);
}

/// The first of a level's located points at the middle of a group of rotations.
std::size_t SearchTables::locate(int level, int group) {
  const auto of_level = static_cast<std::size_t>(level);
  const ScanLevel& scan = blocks_->scan_of(level);
  const PointArrays& points = scan.points;
  LocatedPoints& located = located_[of_level];
  const std::size_t count = points.x.size();
  const std::size_t slot = static_cast<std::size_t>(group) % located.groups.size();
  const std::size_t first = slot * count;
  if (located.groups[slot] != group) {
    const int slack = LatticeBlocks::bounds_of(level).slack;
    rotate(points, blocks_->thetas_of(level, group).first + 0.5 * (scan.turns - 1), -0.5 * slack);
    const CellBox useful{{useful_.min.x - slack, useful_.min.y - slack}, useful_.max};
    find_offsets(rotated_, points.weights, useful, bounds_[of_level].layout(),
                 located.offsets.data() + first, located.weights.data() + first);
    if (level == 0) {
      const int steps_per_cell = blocks_->lattice().steps_per_cell;
      for (std::size_t i = 0; i < count; ++i) {
        located.classes.data()[first + i] =
            rotated_.step_y[i] * steps_per_cell + rotated_.step_x[i];
      }
    }
    located.groups[slot] = group;
  }
  return first;
}

PointWindows SearchTables::bounds(int level, int group, int x, int y) {
  const auto of_level = static_cast<std::size_t>(level);
  const FieldWindow& window = bounds_[of_level];
  const std::size_t first = locate(level, group);
  LocatedPoints& located = located_[of_level];
  return {window.data() + y * window.pitch() + x, window.pitch(), located.offsets.data() + first,
          located.weights.data() + first, blocks_->scan_of(level).points.x.size()};
}

/// The finest bounds have the same layout as the likelihoods, single rotations and no slack: there
/// the points lie at the same offsets.
SearchTables::Cells SearchTables::cells(int theta, int x, int y) {
  static_assert(FieldWindow::kBounds.front().slack == 0 && FieldWindow::kBounds.front().grain == 1);
  const FieldWindow& window = likelihoods_;
  const std::size_t first = locate(0, blocks_->group_of(0, theta));
  LocatedPoints& located = located_.front();
  return {{window.data() + y * window.pitch() + x, window.pitch(), located.offsets.data() + first,
           located.weights.data() + first, blocks_->scan_of(0).points.x.size()},
          located.classes.data() + first};
}

}  // namespace matchbox_slam
