#include "matching/olson/correlative_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <tuple>
#include <utility>

#include "matching/olson/field_window.hpp"
#include "matching/olson/rotated_points.hpp"
#include "matching/olson/scan_level.hpp"
#include "matching/olson/search_penalty.hpp"
#include "matching/olson/window_sums.hpp"

namespace matchbox_slam {
namespace {

constexpr int kTop = FieldWindow::kLevels - 1;
constexpr std::int64_t kTopValue = 255;  // of a cell
constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();

constexpr int kPerAxis = 4;  // blocks of a level in one of the next coarser one
constexpr auto kPerBlock = static_cast<std::size_t>(kPerAxis * kPerAxis);
using BlockSums = std::array<std::uint32_t, kPerBlock>;

/// Rounded towards minus infinity, for a positive divisor.
int floor_div(int value, int divisor) {
  const int quotient = value / divisor;
  return quotient * divisor > value ? quotient - 1 : quotient;
}

/// What is searched as one: a group of rotations with a block of translations, both of one level,
/// counted from the first group and from the offset 0. On level 1, whose blocks are as wide as
/// those of level 0, with 4 x 4 blocks from this one on; above the highest one with all.
struct Node {
  std::int64_t bound = kNone;  ///< no pose scores more
  int level = 0;
  int group = 0;
  int x = 0;
  int y = 0;
  std::uint32_t blocks =
      (1U << kPerBlock) - 1;  ///< a bit for each of 4 x 4 that may be good enough

  /// Whether it is searched later; of equal bounds the finest is searched first.
  [[nodiscard]] bool operator<(const Node& other) const {
    return std::make_tuple(bound, -level, group, y, x) <
           std::make_tuple(other.bound, -other.level, other.group, other.y, other.x);
  }
};

/// Where the points of a level lie in its table, by groups of rotations.
struct LocatedPoints {
  std::vector<int> groups;  ///< of each slot
  // Not filled beforehand: most slots are never used.
  std::unique_ptr<std::int32_t[]> offsets;
  std::unique_ptr<std::uint16_t[]> weights;  ///< of the points that can meet anything, else 0

  void reserve(std::size_t points) {
    if (!offsets) {
      offsets.reset(new std::int32_t[groups.size() * points]);
      weights.reset(new std::uint16_t[groups.size() * points]);
    }
  }
};

/// Cells that the points may fall into at any pose of the lattice.
CellBox cells_in_reach(const PointArrays& points, const SearchLattice& lattice,
                       const GridGeometry& geometry) {
  const double turn = std::min(kPi, lattice.step_theta * lattice.half_theta);
  const double shift = lattice.step_xy(geometry.resolution()) * lattice.half_xy;
  const double cosine = std::cos(lattice.center.theta);
  const double sine = std::sin(lattice.center.theta);
  Eigen::Array2d low = Eigen::Array2d::Zero();
  Eigen::Array2d high = Eigen::Array2d::Zero();
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    const double x = points.x[i];
    const double y = points.y[i];
    const double range = std::sqrt(x * x + y * y);
    // No farther than the arc that the point moves on, nor than its distance from the base.
    const double arc = range * turn;
    const Eigen::Array2d at(cosine * x - sine * y, sine * x + cosine * y);
    low = low.min((at - arc).max(-range));
    high = high.max((at + arc).min(range));
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(shift);
  const Eigen::Vector2d center = lattice.center.translation();
  const Cell first = geometry.cell_at(center + low.matrix() - margin);
  const Cell last = geometry.cell_at(center + high.matrix() + margin);
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

/// One of 4 x 4 blocks.
Node block_at(const Node& blocks, int i) {
  return {kNone, blocks.level, blocks.group, blocks.x + i % kPerAxis, blocks.y + i / kPerAxis};
}

class LatticeSearch {
 public:
  /// @param least_rival  share of the best score below which nothing matters later on.
  LatticeSearch(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                const SearchLattice& lattice, const SearchScoring& scoring, double least_rival,
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

    [[nodiscard]] bool covers(const StepRange& x, const StepRange& y,
                              const StepRange& thetas) const {
      return thetas.first >= center.theta - theta && thetas.last <= center.theta + theta &&
             x.first >= center.x - xy && x.last <= center.x + xy && y.first >= center.y - xy &&
             y.last <= center.y + xy;
    }
  };

  void choose_levels();
  void read_windows(const LikelihoodField& field, const SearchScoring& scoring);
  [[nodiscard]] bool is_in_range() const;
  void rotate(const PointArrays& points, double theta, double shift);
  [[nodiscard]] PointWindows windows_from(int level, int group, int x, int y);
  void bound_roots();
  void dive();
  std::int64_t search_open();
  template <typename Visitor>
  void sum_within(const Node& node, Visitor&& visit);
  template <typename Visitor>
  void sum_within_root(int group, Visitor&& visit) const;
  void add_blocks(const Node& blocks, const BlockSums& sums);
  void add(const Node& node);
  [[nodiscard]] std::int64_t bound_of(const Node& block, std::int64_t most) const;
  [[nodiscard]] bool is_excluded(const Node& node) const;
  void locate_leaf(int theta);
  void search_leaf(const Node& block);
  void consider(const LatticePose& pose, std::int64_t fit);
  void lead(const Leader& leader);
  [[nodiscard]] bool is_late();
  [[nodiscard]] bool is_time_over() const;

  [[nodiscard]] static const BoundLevel& bounds_of(int level) {
    return FieldWindow::kBounds.at(static_cast<std::size_t>(level));
  }

  [[nodiscard]] const ScanLevel& scan_of(int level) const {
    return levels_[static_cast<std::size_t>(level)];
  }

  /// Rotations of a group, within the lattice.
  [[nodiscard]] StepRange thetas_of(int level, int group) const {
    const int turns = scan_of(level).turns;
    const int first = group * turns - lattice_.half_theta;
    return {first, std::min(first + turns - 1, lattice_.half_theta)};
  }

  [[nodiscard]] int last_group(int level) const {
    return 2 * lattice_.half_theta / scan_of(level).turns;
  }

  /// Offsets in steps that a block of a level stands for, within the lattice; none if it is
  /// outside.
  [[nodiscard]] StepRange steps_of(int level, int block) const {
    const int width = lattice_.steps_per_cell * bounds_of(level).stride;
    return {std::max(block * width, -lattice_.half_xy),
            std::min(block * width + width - 1, lattice_.half_xy)};
  }

  /// Blocks of a level that cover the lattice along an axis.
  [[nodiscard]] StepRange blocks_of(int level) const {
    const int width = lattice_.steps_per_cell * bounds_of(level).stride;
    return {floor_div(-lattice_.half_xy, width), floor_div(lattice_.half_xy, width)};
  }

  const SearchLattice& lattice_;
  SearchDeadline deadline_;
  double resolution_;
  SearchPenalty penalty_;
  std::int64_t floor_;
  double least_rival_;
  PointArrays points_;
  int top_ = 1;  ///< coarsest level in use
  std::vector<ScanLevel> levels_;
  CellBox useful_;                    ///< cells from which every look-up stays in the tables
  std::vector<FieldWindow> windows_;  ///< the likelihoods, then the bounds by level
  RotatedPoints rotated_;
  std::vector<LocatedPoints> located_;  ///< by level
  LocatedPoints leaf_;                  ///< in the likelihoods
  std::vector<std::int32_t> classes_;   ///< step within the cell, row by row
  StepRange roots_across_;              ///< coarsest blocks along an axis
  int root_columns_ = 0;                ///< that are summed for them
  int root_rows_ = 0;
  std::vector<std::uint32_t> sums_;  ///< of the coarsest blocks, by groups, then by rows
  std::vector<Node> open_;           ///< to be searched, a heap
  std::vector<Node> done_;           ///< leaves that were
  Leader leader_;
  std::int64_t wanted_ = kNone;  ///< bound below which a node does not matter any more
  Excluded excluded_;
  SearchResult result_;
  bool late_ = false;
  /// What poses of rotations that there was no time to bound score at most.
  std::int64_t passed_over_ = kNone;
};

LatticeSearch::LatticeSearch(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                             const SearchLattice& lattice, const SearchScoring& scoring,
                             double least_rival, const SearchDeadline& deadline)
    : lattice_(lattice),
      deadline_(deadline),
      resolution_(field.geometry().resolution()),
      penalty_(lattice, scoring, resolution_),
      floor_(scoring.floor),
      least_rival_(least_rival) {
  for (const SearchPoint& point : points) {
    points_.x.push_back(point.position.x());
    points_.y.push_back(point.position.y());
    points_.weights.push_back(static_cast<std::uint16_t>(point.weight));
  }
  choose_levels();
  read_windows(field, scoring);
}

void LatticeSearch::choose_levels() {
  // More blocks along an axis than this are worth a coarser level.
  constexpr std::array<int, FieldWindow::kLevels> kMostBlocks = {0, 8, 12, 0};
  while (top_ < kTop && blocks_of(top_).count() > kMostBlocks[static_cast<std::size_t>(top_)]) {
    ++top_;
  }
  roots_across_ = blocks_of(top_);
  root_columns_ = summed_columns(roots_across_.count());
  root_rows_ = summed_rows(roots_across_.count(), root_columns_);
  levels_ = scan_levels(points_, lattice_, resolution_, top_);
  constexpr int kMostLocated = 256;  // groups of a level at a time, to bound the memory
  located_.resize(levels_.size());
  for (int level = 0; level <= top_; ++level) {
    LocatedPoints& located = located_[static_cast<std::size_t>(level)];
    located.groups.assign(static_cast<std::size_t>(std::min(kMostLocated, last_group(level) + 1)),
                          -1);
  }
}

void LatticeSearch::read_windows(const LikelihoodField& field, const SearchScoring& scoring) {
  if (!is_in_range()) {
    return;
  }
  // From the cell of a point without offset, a look-up goes this far at most.
  const int farthest = lattice_.half_xy / lattice_.steps_per_cell + 2 + bounds_of(top_).stride +
                       bounds_of(top_).width();
  const CellBox reach = grown(cells_in_reach(points_, lattice_, field.geometry()), farthest);
  // Twice: a point beyond that meets nothing with any offset.
  CellBox cells = intersection(reach, grown(cells_of(field), 2 * farthest));
  const Cell center = field.geometry().cell_at(lattice_.center.translation());
  cells = intersection(cells, grown({center, {center.x + 1, center.y + 1}}, kFarthestCells));
  useful_ = grown(cells, -farthest);
  if (useful_.empty()) {
    return;
  }
  windows_.push_back(FieldWindow::of_likelihood(field, cells, scoring.value_of_likelihood));
  std::vector<FieldWindow> bounds = windows_.front().bounds(top_);
  std::move(bounds.begin(), bounds.end(), std::back_inserter(windows_));
  classes_.resize(points_.x.size());
}

/// Whether steps from the map's origin are counted in 32 bits without overflow.
bool LatticeSearch::is_in_range() const {
  constexpr double kMost = 1 << 30;
  const double farthest_point = 1e5;  // [m], see SearchPoint
  const double farthest = lattice_.center.translation().cwiseAbs().maxCoeff() + farthest_point;
  return farthest / lattice_.step_xy(resolution_) < kMost;
}

/// @param theta  [steps]
/// @param shift  of all points, along both axes [cells].
void LatticeSearch::rotate(const PointArrays& points, double theta, double shift) {
  const double angle = lattice_.center.theta + lattice_.step_theta * theta;
  const Rotation rotation{std::cos(angle),
                          std::sin(angle),
                          lattice_.center.x + shift * resolution_,
                          lattice_.center.y + shift * resolution_,
                          lattice_.steps_per_cell / resolution_,
                          static_cast<double>(lattice_.steps_per_cell)};
  rotate_points(points, rotation, rotated_);
}

/// The windows of a level's points in its table, moved by blocks.
PointWindows LatticeSearch::windows_from(int level, int group, int x, int y) {
  const auto of_level = static_cast<std::size_t>(level);
  const FieldWindow& window = windows_[of_level + 1];
  const PointArrays& points = scan_of(level).points;
  LocatedPoints& located = located_[of_level];
  const std::size_t count = points.x.size();
  const std::size_t slot = static_cast<std::size_t>(group) % located.groups.size();
  const std::size_t first = slot * count;
  if (located.groups[slot] != group) {
    located.reserve(count);
    const int slack = bounds_of(level).slack;
    rotate(points, thetas_of(level, group).first + 0.5 * (scan_of(level).turns - 1), -0.5 * slack);
    const CellBox useful{{useful_.min.x - slack, useful_.min.y - slack}, useful_.max};
    find_offsets(rotated_, points.weights, useful, window.layout(), &located.offsets[first],
                 &located.weights[first]);
    located.groups[slot] = group;
  }
  return {window.data() + y * window.pitch() + x, window.pitch(), &located.offsets[first],
          &located.weights[first], count};
}

/// Sums of the coarsest blocks, and what no pose of each of the largest groups of rotations scores
/// more than.
void LatticeSearch::bound_roots() {
  const int last = last_group(top_);
  const int center = lattice_.half_theta / scan_of(top_).turns;
  const auto size = static_cast<std::size_t>(root_columns_ * root_rows_);
  sums_.resize(size * static_cast<std::size_t>(last + 1));
  for (int i = 0; i <= 2 * std::max(center, last - center); ++i) {
    const int group = i % 2 == 0 ? center - i / 2 : center + i / 2 + 1;  // from the center outwards
    if (group < 0 || group > last) {
      continue;
    }
    if (i > 0 && is_time_over()) {
      passed_over_ = kTopValue * std::accumulate(points_.weights.begin(), points_.weights.end(),
                                                 std::int64_t{0});
      break;
    }
    std::uint32_t* sums = &sums_[size * static_cast<std::size_t>(group)];
    const PointWindows windows =
        windows_from(top_, group, roots_across_.first, roots_across_.first);
    sum_windows(windows, root_rows_, root_columns_, sums);
    result_.look_ups +=
        windows.count * static_cast<std::size_t>(root_rows_ * root_columns_) / kPerBlock;
    const int count = roots_across_.count();
    result_.bounded += static_cast<std::size_t>(count * count);
    std::uint32_t most = 0;
    for (int row = 0; row < count; ++row, sums += root_columns_) {
      most = std::max(most, *std::max_element(sums, sums + count));
    }
    open_.push_back(
        {most + scan_of(top_).unbounded - penalty_.least(thetas_of(top_, group)), top_ + 1, group});
  }
  std::make_heap(open_.begin(), open_.end());
}

void LatticeSearch::find_best() {
  if (windows_.empty()) {
    // Nothing is in reach of any pose, so the least penalty wins: the center's.
    result_.candidates = 1;
    result_.is_found = result_.score > floor_;
    return;
  }
  lead({{}, floor_});
  bound_roots();
  dive();
  const std::int64_t left = search_open();
  result_.is_found = leader_.score > floor_;
  result_.best = leader_.pose;
  result_.score = leader_.score;
  result_.bound = std::max({leader_.score, left, passed_over_});
}

void LatticeSearch::find_rival(const RivalSearch& rivals) {
  const Excluded around_best{result_.best, rivals.xy, rivals.theta};
  const StepRange all{-lattice_.half_xy, lattice_.half_xy};
  if (!result_.is_found || windows_.empty() || result_.bound > result_.score ||
      result_.score <= 0 ||
      around_best.covers(all, all, {-lattice_.half_theta, lattice_.half_theta})) {
    return;
  }
  const auto least = static_cast<std::int64_t>(least_rival_ * static_cast<double>(result_.score));
  excluded_ = around_best;
  least_rival_ = 1.0;
  lead({result_.best, least});
  for (const Node& leaf : std::exchange(done_, {})) {
    add(leaf);
  }
  result_.rivals_left = std::max(std::int64_t{0}, search_open());
  if (leader_.score > least) {
    result_.rival = Rival{leader_.pose, leader_.score};
  }
}

/// Finds a first leader: the way down where the sums are best.
void LatticeSearch::dive() {
  Node node = open_.front();
  while (node.level > 0) {
    Node best;
    sum_within(node, [&](const Node& blocks, const BlockSums& sums) {
      const StepRange thetas = thetas_of(blocks.level, blocks.group);
      for (int i = 0; i < static_cast<int>(kPerBlock); ++i) {
        const Node block = block_at(blocks, i);
        const StepRange x = steps_of(block.level, block.x);
        const StepRange y = steps_of(block.level, block.y);
        if (x.count() > 0 && y.count() > 0) {
          const std::int64_t guess = sums[static_cast<std::size_t>(i)] -
                                     penalty_.at({(x.first + x.last) / 2, (y.first + y.last) / 2,
                                                  (thetas.first + thetas.last) / 2});
          if (best.bound == kNone || guess > best.bound) {
            best = block;
            best.bound = guess;
          }
        }
      }
    });
    node = best;
  }
  search_leaf(node);
}

/// Looks for a better leader, always where the bound is highest. Returns what the poses that it had
/// no time for score at most.
std::int64_t LatticeSearch::search_open() {
  while (!open_.empty() && open_.front().bound >= leader_.score) {
    if (is_late()) {
      return open_.front().bound;
    }
    std::pop_heap(open_.begin(), open_.end());
    const Node node = open_.back();
    open_.pop_back();
    if (is_excluded(node)) {
      continue;
    }
    if (node.level == 0) {
      search_leaf(node);
      done_.push_back(node);
    } else {
      sum_within(node,
                 [&](const Node& blocks, const BlockSums& sums) { add_blocks(blocks, sums); });
    }
  }
  return kNone;
}

/// Sums of the blocks of the next finer level that are within a node, 4 x 4 at a time.
template <typename Visitor>
void LatticeSearch::sum_within(const Node& node, Visitor&& visit) {
  static_assert(summed_columns(kPerAxis) == kPerAxis &&
                summed_rows(kPerAxis, kPerAxis) == kPerAxis);
  if (node.level > top_) {
    sum_within_root(node.group, visit);
    return;
  }
  Node blocks = node;
  blocks.level = node.level - 1;
  const int finer = bounds_of(node.level).stride / bounds_of(blocks.level).stride;
  blocks.x *= finer;
  blocks.y *= finer;
  const StepRange thetas = thetas_of(node.level, node.group);
  const int turns = scan_of(blocks.level).turns;
  BlockSums sums;
  for (int theta = thetas.first; theta <= thetas.last; theta += turns) {
    blocks.group = (theta + lattice_.half_theta) / turns;
    const PointWindows windows = windows_from(blocks.level, blocks.group, blocks.x, blocks.y);
    sum_windows(windows, kPerAxis, kPerAxis, sums.data());
    result_.look_ups += windows.count;
    result_.bounded += kPerBlock;
    visit(blocks, sums);
  }
}

template <typename Visitor>
void LatticeSearch::sum_within_root(int group, Visitor&& visit) const {
  const std::uint32_t* from = &sums_[static_cast<std::size_t>(group * root_columns_ * root_rows_)];
  BlockSums sums;
  for (int y = 0; y < roots_across_.count(); y += kPerAxis) {
    for (int x = 0; x < roots_across_.count(); x += kPerAxis) {
      for (int i = 0; i < static_cast<int>(kPerBlock); ++i) {
        const int row = std::min(y + i / kPerAxis, root_rows_ - 1);
        const int column = std::min(x + i % kPerAxis, root_columns_ - 1);
        sums[static_cast<std::size_t>(i)] = from[row * root_columns_ + column];
      }
      visit(Node{kNone, top_, group, roots_across_.first + x, roots_across_.first + y}, sums);
    }
  }
}

/// Adds those of 4 x 4 blocks that may be good enough: on level 1 together.
void LatticeSearch::add_blocks(const Node& blocks, const BlockSums& sums) {
  const std::int64_t unbounded = scan_of(blocks.level).unbounded;
  const std::int64_t least = penalty_.least(thetas_of(blocks.level, blocks.group));
  Node together = blocks;
  together.bound = kNone;
  together.blocks = 0;
  for (int i = 0; i < static_cast<int>(kPerBlock); ++i) {
    const std::int64_t most = sums[static_cast<std::size_t>(i)] + unbounded;
    if ((blocks.blocks >> i & 1U) == 0 || most - least < wanted_) {
      continue;
    }
    Node block = block_at(blocks, i);
    block.bound = bound_of(block, most);
    if (blocks.level != 1) {
      add(block);
    } else if (block.bound != kNone && block.bound >= wanted_) {
      together.blocks |= 1U << i;
      together.bound = std::max(together.bound, block.bound);
    }
  }
  add(together);
}

/// What no pose of a block that may be the answer scores more than.
/// @param most  that their points do.
std::int64_t LatticeSearch::bound_of(const Node& block, std::int64_t most) const {
  const StepRange x = steps_of(block.level, block.x);
  const StepRange y = steps_of(block.level, block.y);
  const StepRange thetas = thetas_of(block.level, block.group);
  return x.count() <= 0 || y.count() <= 0 ? kNone : most - penalty_.least(x, y, thetas);
}

bool LatticeSearch::is_excluded(const Node& node) const {
  if (node.level > top_) {
    return false;
  }
  const int last = node.level == 1 ? kPerAxis - 1 : 0;  // of the blocks along an axis
  const auto steps = [&](int first) -> StepRange {
    return {steps_of(node.level, first).first, steps_of(node.level, first + last).last};
  };
  return excluded_.covers(steps(node.x), steps(node.y), thetas_of(node.level, node.group));
}

void LatticeSearch::add(const Node& node) {
  if (node.bound != kNone && node.bound >= wanted_) {
    open_.push_back(node);
    std::push_heap(open_.begin(), open_.end());
  }
}

/// Finds the points in the likelihoods.
void LatticeSearch::locate_leaf(int theta) {
  if (!leaf_.groups.empty() && leaf_.groups.front() == theta) {
    return;
  }
  leaf_.groups = {theta};
  leaf_.reserve(points_.x.size());
  rotate(points_, theta, 0.0);
  find_offsets(rotated_, points_.weights, useful_, windows_.front().layout(), leaf_.offsets.get(),
               leaf_.weights.get());
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    classes_[i] = rotated_.step_y[i] * lattice_.steps_per_cell + rotated_.step_x[i];
  }
}

/// All poses within one cell's width of translations. A point crosses into the next cell when its
/// step within the cell and the offset's add up to a cell; so the sums of four cells for each class
/// of points give the fit of every pose.
void LatticeSearch::search_leaf(const Node& block) {
  const int n = lattice_.steps_per_cell;
  const auto size = static_cast<std::size_t>(n);
  const int theta = thetas_of(0, block.group).first;
  locate_leaf(theta);
  const FieldWindow& window = windows_.front();
  result_.look_ups += points_.x.size();
  std::vector<std::uint32_t> of_class(4 * size * size, 0);
  sum_corners({window.data() + block.y * window.pitch() + block.x, window.pitch(),
               leaf_.offsets.get(), leaf_.weights.get(), points_.x.size()},
              classes_.data(), of_class.data());
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
      consider({x, y, theta}, fit);
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
  if (is_better &&
      !excluded_.covers({pose.x, pose.x}, {pose.y, pose.y}, {pose.theta, pose.theta})) {
    lead({pose, score});
  }
}

void LatticeSearch::lead(const Leader& leader) {
  leader_ = leader;
  wanted_ = std::min(leader.score,
                     static_cast<std::int64_t>(least_rival_ * static_cast<double>(leader.score)));
}

bool LatticeSearch::is_late() {
  const bool may_end = leader_.score > floor_ || floor_ > SearchScoring{}.floor;
  late_ = late_ || (may_end && (is_time_over() || result_.look_ups > deadline_.look_ups));
  return late_;
}

bool LatticeSearch::is_time_over() const {
  return deadline_.time && std::chrono::steady_clock::now() >= *deadline_.time;
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
  LatticeSearch search(points, field, lattice, scoring, rivals ? rivals->least : 1.0, deadline);
  search.find_best();
  if (rivals) {
    search.find_rival(*rivals);
  }
  return search.result();
}

}  // namespace matchbox_slam
