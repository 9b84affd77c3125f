#include "matching/olson/correlative_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numeric>
#include <tuple>

#include "matching/olson/field_window.hpp"
#include "matching/olson/rotated_points.hpp"
#include "matching/olson/search_penalty.hpp"
#include "matching/olson/window_sums.hpp"

namespace matchbox_slam {
namespace {

constexpr int kTop = FieldWindow::kLevels - 1;
constexpr std::int64_t kTopValue = 255;  // of a cell

/// Rounded towards minus infinity, for a positive divisor.
int floor_div(int value, int divisor) {
  const int quotient = value / divisor;
  return quotient * divisor > value ? quotient - 1 : quotient;
}

/// A square of translations: on level l, 4^l cells wide; its number counts such blocks from the
/// offset 0.
struct Block {
  int x = 0;
  int y = 0;
  std::int64_t bound = 0;
};

/// Cells that the points may fall into at any pose of the lattice.
CellBox cells_in_reach(const PointArrays& points, const SearchLattice& lattice,
                       const GridGeometry& geometry) {
  const double turn = std::min(kPi, lattice.step_theta * lattice.half_theta);
  const double shift = lattice.step_xy(geometry.resolution()) * lattice.half_xy;
  Eigen::Vector2d low = lattice.center.translation();
  Eigen::Vector2d high = low;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    const Eigen::Vector2d point(points.x[i], points.y[i]);
    const double range = point.norm();
    // No farther than the arc that the point moves on, nor than its distance from the base.
    const double arc = range * turn;
    const Eigen::Vector2d at = lattice.center * point;
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(range);
    const Eigen::Vector2d away = Eigen::Vector2d::Constant(arc);
    low = low.cwiseMin((at - away).cwiseMax(lattice.center.translation() - reach));
    high = high.cwiseMax((at + away).cwiseMin(lattice.center.translation() + reach));
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(shift);
  const Cell first = geometry.cell_at(low - margin);
  const Cell last = geometry.cell_at(high + margin);
  return {{first.x - 1, first.y - 1}, {last.x + 2, last.y + 2}};
}

CellBox grown(const CellBox& box, int by) {
  return {{box.min.x - by, box.min.y - by}, {box.max.x + by, box.max.y + by}};
}

/// Cells for which the field has tiles.
CellBox cells_of(const LikelihoodField& field) {
  constexpr int kSize = LikelihoodField::Tiles::kTileSize;
  const CellBox tiles = field.tiles().tile_bounds();
  return {{tiles.min.x * kSize, tiles.min.y * kSize}, {tiles.max.x * kSize, tiles.max.y * kSize}};
}

class LatticeSearch {
 public:
  LatticeSearch(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                const SearchLattice& lattice, const SearchScoring& scoring,
                const SearchDeadline& deadline);

  void find_best();
  void find_rival(const RivalSearch& rivals);
  [[nodiscard]] const SearchResult& result() const { return result_; }

 private:
  /// The best pose that was seen so far; what cannot beat it is passed over.
  struct Leader {
    LatticePose pose;
    std::int64_t score = 0;
  };

  /// Poses that are not looked for: all that are near another one.
  struct Excluded {
    LatticePose center;
    int xy = -1;
    int theta = -1;

    [[nodiscard]] bool covers(const StepRange& x, const StepRange& y, int at_theta) const {
      return std::abs(at_theta - center.theta) <= theta && x.first >= center.x - xy &&
             x.last <= center.x + xy && y.first >= center.y - xy && y.last <= center.y + xy;
    }
  };

  /// All poses of one rotation.
  struct Slice {
    int theta = 0;
    std::int64_t bound = 0;
    std::size_t sums = 0;  ///< of its coarsest blocks, the first one
  };

  void read_windows(const LikelihoodField& field, const SearchScoring& scoring);
  [[nodiscard]] bool is_in_range() const;
  void rotate();
  void locate(std::size_t table);
  [[nodiscard]] PointWindows windows_from(std::size_t table, int x, int y);
  void bound_slice();
  void bound_slices();
  std::int64_t search_slices();
  void search_slice(const Slice& slice);
  void search_blocks(int level, const StepRange& x, const StepRange& y, const std::uint32_t* sums,
                     int columns);
  void search_children(int level, const Block& block);
  void search_leaf(const Block& block);
  void consider(const LatticePose& pose, std::int64_t fit);
  [[nodiscard]] bool is_late();

  /// Offsets in steps that a block of a level stands for, within the lattice.
  [[nodiscard]] StepRange steps_of(int level, int block) const {
    const int width = lattice_.steps_per_cell * FieldWindow::stride(level);
    return {std::max(block * width, -lattice_.half_xy),
            std::min(block * width + width - 1, lattice_.half_xy)};
  }

  /// Blocks of a level that cover the lattice along an axis.
  [[nodiscard]] StepRange blocks_of(int level) const {
    const int width = lattice_.steps_per_cell * FieldWindow::stride(level);
    return {floor_div(-lattice_.half_xy, width), floor_div(lattice_.half_xy, width)};
  }

  static constexpr int kNowhere = std::numeric_limits<int>::min();

  const SearchLattice& lattice_;
  SearchDeadline deadline_;
  double resolution_;
  SearchPenalty penalty_;
  std::int64_t floor_;
  PointArrays points_;
  int top_ = 0;                       ///< coarsest level in use
  CellBox cells_;                     ///< that can be looked up
  CellBox useful_;                    ///< those from which every look-up stays there
  std::vector<FieldWindow> windows_;  ///< the likelihoods, then the bounds by level
  RotatedPoints rotated_;
  std::vector<std::vector<std::int32_t>> offsets_;  ///< at the present rotation, in each window
  std::vector<std::uint16_t> weights_;  ///< of the points that can meet anything, else 0
  std::vector<std::int32_t> classes_;   ///< step within the cell, row by row
  int theta_ = kNowhere;                ///< the present rotation
  int rotated_to_ = kNowhere;
  std::vector<int> located_at_;      ///< rotation at which the points were found in each window
  std::vector<std::uint32_t> sums_;  ///< of the coarsest blocks, by rotations, then by rows
  std::vector<Slice> slices_;
  Leader leader_;
  Excluded excluded_;
  SearchResult result_;
  bool late_ = false;
  /// What poses of rotations that there was no time to bound score at most.
  std::int64_t passed_over_ = std::numeric_limits<std::int64_t>::min();
};

// More blocks along an axis than this are worth a coarser level.
constexpr int kMostBlocks = 8;

LatticeSearch::LatticeSearch(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                             const SearchLattice& lattice, const SearchScoring& scoring,
                             const SearchDeadline& deadline)
    : lattice_(lattice),
      deadline_(deadline),
      resolution_(field.geometry().resolution()),
      penalty_(lattice, scoring, resolution_),
      floor_(scoring.floor) {
  for (const SearchPoint& point : points) {
    points_.x.push_back(point.position.x());
    points_.y.push_back(point.position.y());
    points_.weights.push_back(static_cast<std::uint16_t>(point.weight));
  }
  while (top_ < kTop && blocks_of(top_).count() > kMostBlocks) {
    ++top_;
  }
  read_windows(field, scoring);
}

void LatticeSearch::read_windows(const LikelihoodField& field, const SearchScoring& scoring) {
  if (!is_in_range()) {
    return;
  }
  // From the cell of a point without offset, a look-up goes this far at most.
  const int farthest =
      lattice_.half_xy / lattice_.steps_per_cell + 2 + 2 * FieldWindow::stride(top_);
  const CellBox reach = grown(cells_in_reach(points_, lattice_, field.geometry()), farthest);
  // Twice: a point beyond that meets nothing with any offset.
  cells_ = intersection(reach, grown(cells_of(field), 2 * farthest));
  const Cell center = field.geometry().cell_at(lattice_.center.translation());
  cells_ = intersection(cells_, grown({center, {center.x + 1, center.y + 1}}, kFarthestCells));
  useful_ = grown(cells_, -farthest);
  if (useful_.empty()) {
    return;
  }
  windows_.push_back(FieldWindow::of_likelihood(field, cells_, scoring.value_of_likelihood));
  std::vector<FieldWindow> bounds = windows_.front().bounds(top_);
  std::move(bounds.begin(), bounds.end(), std::back_inserter(windows_));
  offsets_.resize(windows_.size());
  located_at_.resize(windows_.size(), kNowhere);
  classes_.resize(points_.x.size());
}

/// Whether steps from the map's origin are counted in 32 bits without overflow.
bool LatticeSearch::is_in_range() const {
  constexpr double kMost = 1 << 30;
  const double farthest_point = 1e5;  // [m], see SearchPoint
  const double farthest = lattice_.center.translation().cwiseAbs().maxCoeff() + farthest_point;
  return farthest / lattice_.step_xy(resolution_) < kMost;
}

void LatticeSearch::rotate() {
  const double angle = lattice_.center.theta + lattice_.step_theta * theta_;
  const Rotation rotation{std::cos(angle),
                          std::sin(angle),
                          lattice_.center.x,
                          lattice_.center.y,
                          lattice_.steps_per_cell / resolution_,
                          static_cast<double>(lattice_.steps_per_cell)};
  rotate_points(points_, rotation, rotated_);
  rotated_to_ = theta_;
}

/// Finds the points' windows in a table at the present rotation.
void LatticeSearch::locate(std::size_t table) {
  if (located_at_[table] == theta_) {
    return;
  }
  if (rotated_to_ != theta_) {
    rotate();
  }
  find_offsets(rotated_, points_.weights, useful_, windows_[table].layout(), offsets_[table],
               weights_);
  for (std::size_t i = 0; table == 0 && i < classes_.size(); ++i) {
    classes_[i] = rotated_.step_y[i] * lattice_.steps_per_cell + rotated_.step_x[i];
  }
  located_at_[table] = theta_;
}

/// The points' windows in a table, moved by entries.
PointWindows LatticeSearch::windows_from(std::size_t table, int x, int y) {
  locate(table);
  const FieldWindow& window = windows_[table];
  return {window.data() + y * window.pitch() + x, window.pitch(), offsets_[table].data(),
          weights_.data(), weights_.size()};
}

/// At the present rotation: sums of the coarsest blocks, and what no pose scores more than.
void LatticeSearch::bound_slice() {
  const std::size_t table = static_cast<std::size_t>(top_) + 1;
  const StepRange blocks = blocks_of(top_);
  const int columns = summed_columns(blocks.count());
  const int rows = summed_rows(blocks.count(), columns);
  const std::size_t first = sums_.size();
  sums_.resize(first + static_cast<std::size_t>(rows * columns));
  sum_windows(windows_from(table, blocks.first, blocks.first), rows, columns, &sums_[first]);
  result_.bounded += static_cast<std::size_t>(blocks.count() * blocks.count());
  std::uint32_t most = 0;
  for (int row = 0; row < blocks.count(); ++row) {
    const std::uint32_t* sums = &sums_[first] + static_cast<std::ptrdiff_t>(row) * columns;
    most = std::max(most, *std::max_element(sums, sums + blocks.count()));
  }
  slices_.push_back({theta_, static_cast<std::int64_t>(most) - penalty_.least(theta_), first});
}

void LatticeSearch::bound_slices() {
  for (int i = 0; i <= 2 * lattice_.half_theta; ++i) {
    const int theta = i % 2 == 0 ? -(i / 2) : i / 2 + 1;  // from the center outwards
    if (i > 0 && deadline_ && std::chrono::steady_clock::now() >= *deadline_) {
      passed_over_ = kTopValue * std::accumulate(points_.weights.begin(), points_.weights.end(),
                                                 std::int64_t{0});
      break;
    }
    theta_ = theta;
    bound_slice();
  }
  std::sort(slices_.begin(), slices_.end(), [](const Slice& a, const Slice& b) {
    return std::make_tuple(-a.bound, std::abs(a.theta), a.theta) <
           std::make_tuple(-b.bound, std::abs(b.theta), b.theta);
  });
}

void LatticeSearch::find_best() {
  if (windows_.empty()) {
    // Nothing is in reach of any pose, so the least penalty wins: the center's.
    result_.candidates = 1;
    result_.is_found = result_.score > floor_;
    return;
  }
  leader_.score = floor_;
  bound_slices();
  const std::int64_t left = search_slices();
  result_.is_found = leader_.score > floor_;
  result_.best = leader_.pose;
  result_.score = leader_.score;
  result_.bound = std::max({leader_.score, left, passed_over_});
}

void LatticeSearch::find_rival(const RivalSearch& rivals) {
  const Excluded around_best{result_.best, rivals.xy, rivals.theta};
  const StepRange all{-lattice_.half_xy, lattice_.half_xy};
  if (!result_.is_found || slices_.empty() || result_.bound > result_.score || result_.score <= 0 ||
      (around_best.covers(all, all, -lattice_.half_theta) &&
       around_best.covers(all, all, lattice_.half_theta))) {
    return;
  }
  const auto least = static_cast<std::int64_t>(rivals.least * static_cast<double>(result_.score));
  excluded_ = around_best;
  leader_ = {result_.best, least};
  search_slices();
  if (leader_.score > least) {
    result_.rival = Rival{leader_.pose, leader_.score};
  }
}

/// Looks for a better leader. Returns what the poses that it had no time for score at most.
std::int64_t LatticeSearch::search_slices() {
  for (const Slice& slice : slices_) {
    if (slice.bound < leader_.score) {
      break;
    }
    search_slice(slice);
    if (late_) {
      return slice.bound;
    }
  }
  return std::numeric_limits<std::int64_t>::min();
}

void LatticeSearch::search_slice(const Slice& slice) {
  theta_ = slice.theta;
  const StepRange blocks = blocks_of(top_);
  search_blocks(top_, blocks, blocks, &sums_[slice.sums], summed_columns(blocks.count()));
}

/// Searches the blocks that may hold something better, the most promising first.
void LatticeSearch::search_blocks(int level, const StepRange& x, const StepRange& y,
                                  const std::uint32_t* sums, int columns) {
  const std::int64_t least = penalty_.least(theta_);
  std::vector<Block> blocks;
  for (int row = 0; row < y.count(); ++row) {
    for (int column = 0; column < x.count(); ++column) {
      Block block{x.first + column, y.first + row, sums[row * columns + column]};
      if (block.bound - least < leader_.score) {
        continue;
      }
      const StepRange steps_x = steps_of(level, block.x);
      const StepRange steps_y = steps_of(level, block.y);
      block.bound -= penalty_.least(steps_x, steps_y, theta_);
      if (block.bound >= leader_.score && !excluded_.covers(steps_x, steps_y, theta_)) {
        blocks.push_back(block);
      }
    }
  }
  std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) {
    return std::make_tuple(-a.bound, a.y, a.x) < std::make_tuple(-b.bound, b.y, b.x);
  });
  for (const Block& block : blocks) {
    if (block.bound < leader_.score || is_late()) {
      return;
    }
    if (level == 0) {
      search_leaf(block);
    } else {
      search_children(level, block);
    }
  }
}

void LatticeSearch::search_children(int level, const Block& block) {
  constexpr int kPerAxis = 4;
  const StepRange all = blocks_of(level - 1);
  const StepRange x{std::max(all.first, kPerAxis * block.x),
                    std::min(all.last, kPerAxis * block.x + kPerAxis - 1)};
  const StepRange y{std::max(all.first, kPerAxis * block.y),
                    std::min(all.last, kPerAxis * block.y + kPerAxis - 1)};
  std::array<std::uint32_t, static_cast<std::size_t>(kPerAxis * kPerAxis)> sums{};
  static_assert(summed_columns(kPerAxis) == kPerAxis &&
                summed_rows(kPerAxis, kPerAxis) == kPerAxis);
  sum_windows(windows_from(static_cast<std::size_t>(level), x.first, y.first), kPerAxis, kPerAxis,
              sums.data());
  result_.bounded += static_cast<std::size_t>(x.count() * y.count());
  search_blocks(level - 1, x, y, sums.data(), kPerAxis);
}

/// All poses within one cell's width of translations. A point crosses into the next cell when its
/// step within the cell and the offset's add up to a cell; so the sums of four cells for each class
/// of points give the fit of every pose.
void LatticeSearch::search_leaf(const Block& block) {
  const int n = lattice_.steps_per_cell;
  const auto size = static_cast<std::size_t>(n);
  std::vector<std::uint32_t> of_class(4 * size * size, 0);
  sum_corners(windows_from(0, block.x, block.y), classes_.data(), of_class.data());
  const StepRange steps_x = steps_of(0, block.x);
  const StepRange steps_y = steps_of(0, block.y);
  std::vector<std::int64_t> of_row(2 * size);  // by row's class, then whether it crosses in y
  for (int x = steps_x.first; x <= steps_x.last; ++x) {
    const int offset_x = x - block.x * n;
    for (int row = 0; row < n; ++row) {
      for (int crosses_y = 0; crosses_y < 2; ++crosses_y) {
        std::int64_t sum = 0;
        for (int column = 0; column < n; ++column) {
          const int crosses_x = column + offset_x >= n ? 1 : 0;
          const int corner = 4 * (row * n + column) + 2 * crosses_y + crosses_x;
          sum += of_class[static_cast<std::size_t>(corner)];
        }
        const int of_this = 2 * row + crosses_y;
        of_row[static_cast<std::size_t>(of_this)] = sum;
      }
    }
    for (int y = steps_y.first; y <= steps_y.last; ++y) {
      const int offset_y = y - block.y * n;
      std::int64_t fit = 0;
      for (int row = 0; row < n; ++row) {
        const int crosses = row + offset_y >= n ? 2 * row + 1 : 2 * row;
        fit += of_row[static_cast<std::size_t>(crosses)];
      }
      consider({x, y, theta_}, fit);
    }
  }
}

void LatticeSearch::consider(const LatticePose& pose, std::int64_t fit) {
  ++result_.candidates;
  if (fit < leader_.score) {
    return;
  }
  const std::int64_t score = fit - penalty_.at(pose);
  const auto order = [](const LatticePose& p) {
    return std::make_tuple(std::abs(p.theta), std::abs(p.x) + std::abs(p.y), p.theta, p.y, p.x);
  };
  const bool is_better =
      score > leader_.score || (score == leader_.score && order(pose) < order(leader_.pose));
  if (is_better && !excluded_.covers({pose.x, pose.x}, {pose.y, pose.y}, pose.theta)) {
    leader_ = {pose, score};
  }
}

bool LatticeSearch::is_late() {
  const bool may_end = leader_.score > floor_ || floor_ > SearchScoring{}.floor;
  late_ = late_ || (deadline_ && may_end && std::chrono::steady_clock::now() >= *deadline_);
  return late_;
}

}  // namespace

Pose2 pose_at(const SearchLattice& lattice, const LatticePose& at, double resolution) {
  const double step = lattice.step_xy(resolution);
  return {lattice.center.x + step * at.x, lattice.center.y + step * at.y,
          wrap_angle(lattice.center.theta + lattice.step_theta * at.theta)};
}

SearchResult search_lattice(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                            const SearchLattice& lattice, const SearchScoring& scoring,
                            const std::optional<RivalSearch>& rivals,
                            const SearchDeadline& deadline) {
  LatticeSearch search(points, field, lattice, scoring, deadline);
  search.find_best();
  if (rivals) {
    search.find_rival(*rivals);
  }
  return search.result();
}

}  // namespace matchbox_slam
