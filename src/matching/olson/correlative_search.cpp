#include "matching/olson/correlative_search.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "matching/olson/lattice_blocks.hpp"
#include "matching/olson/search_penalty.hpp"
#include "matching/olson/search_tables.hpp"
#include "matching/olson/window_sums.hpp"

namespace matchbox_slam {
namespace {

constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();

constexpr int kChildrenPerAxis = 4;  // blocks of a level in one of the next coarser one
constexpr auto kChildren = std::size_t{kChildrenPerAxis} * kChildrenPerAxis;
using BlockSums = std::array<std::uint32_t, kChildren>;

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
      (1U << kChildren) - 1;  ///< a bit for each of 4 x 4 that may be good enough

  /// Whether it is searched later; of equal bounds the finest is searched first.
  [[nodiscard]] bool operator<(const Node& other) const {
    return std::make_tuple(bound, -level, group, y, x) <
           std::make_tuple(other.bound, -other.level, other.group, other.y, other.x);
  }
};

/// One of 4 x 4 blocks.
Node block_at(const Node& blocks, int i) {
  return {kNone, blocks.level, blocks.group, blocks.x + i % kChildrenPerAxis,
          blocks.y + i / kChildrenPerAxis};
}

}  // namespace

struct SearchMemory::Parts {
  SearchLimits limits;
  PointArrays points;
  LatticeBlocks blocks;
  SearchTables tables;
  std::vector<std::uint32_t> sums;      ///< of the coarsest blocks, by groups, then by rows
  std::vector<Node> open;               ///< to be searched, a heap
  std::vector<Node> done;               ///< leaves that were
  std::vector<std::uint64_t> of_class;  ///< of a leaf, by class of points and row: see sum_corners
  std::vector<std::int64_t> of_row;     ///< by row's class, then whether it crosses in y

  void clear() {
    points.clear();
    open.clear();
    done.clear();
  }

  void let_go() {
    constexpr std::size_t kKeptBytes = std::size_t{1} << 20;  // bytes of each
    const auto shrink = [](auto& elements) {
      if (elements.capacity() * sizeof(elements.front()) > kKeptBytes) {
        elements = {};
      }
    };
    shrink(sums);
    shrink(open);
    shrink(done);
  }
};

SearchMemory::SearchMemory(const SearchLimits& limits) : parts_(std::make_unique<Parts>()) {
  parts_->limits = limits;
}
SearchMemory::SearchMemory(SearchMemory&& other) noexcept = default;
SearchMemory& SearchMemory::operator=(SearchMemory&& other) noexcept = default;
SearchMemory::~SearchMemory() = default;

namespace {

class LatticeSearch {
 public:
  /// @param least_rival  share of the best score below which nothing matters later on.
  LatticeSearch(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                const SearchLattice& lattice, const SearchScoring& scoring, double least_rival,
                const SearchDeadline& deadline, SearchMemory::Parts& memory);

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

  void bound_roots();
  void dive();
  std::int64_t search_open();
  template <typename Visitor>
  void sum_within(const Node& node, Visitor&& visit);
  template <typename Visitor>
  void sum_within_root(int group, Visitor&& visit);
  void add_blocks(const Node& blocks, const BlockSums& sums);
  void add(const Node& node);
  void search(const Node& node);
  [[nodiscard]] std::size_t root_size() const {
    return static_cast<std::size_t>(root_columns_) * static_cast<std::size_t>(root_rows_);
  }
  const std::uint32_t* sum_root(int group);
  [[nodiscard]] std::int64_t bound_of(const Node& block, std::int64_t most) const;
  [[nodiscard]] bool is_excluded(const Node& node) const;
  void search_leaf(const Node& block);
  void consider(const LatticePose& pose, std::int64_t fit);
  void lead(const Leader& leader);
  [[nodiscard]] bool is_late();
  [[nodiscard]] bool is_time_over() const;

  SearchDeadline deadline_;
  SearchPenalty penalty_;
  std::int64_t floor_;
  double least_rival_;
  SearchMemory::Parts& memory_;
  PointArrays& points_;
  LatticeBlocks& blocks_;
  SearchTables& tables_;
  std::vector<Node>& open_;
  std::vector<Node>& done_;
  StepRange roots_across_;  ///< coarsest blocks along an axis
  int root_columns_ = 0;    ///< that are summed for them
  int root_rows_ = 0;
  bool keeps_root_sums_ = true;  ///< of all groups, else of the last one alone
  bool has_all_done_ = true;     ///< of the leaves, and all that wait; else there were too many
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
                             double least_rival, const SearchDeadline& deadline,
                             SearchMemory::Parts& memory)
    : deadline_(deadline),
      penalty_(lattice, scoring, field.geometry().resolution()),
      floor_(scoring.floor),
      least_rival_(least_rival),
      memory_(memory),
      points_(memory.points),
      blocks_(memory.blocks),
      tables_(memory.tables),
      open_(memory.open),
      done_(memory.done) {
  memory_.clear();
  for (const SearchPoint& point : points) {
    points_.x.push_back(point.position.x());
    points_.y.push_back(point.position.y());
    points_.weights.push_back(static_cast<std::uint16_t>(point.weight));
  }
  blocks_.assign(points_, lattice, field.geometry().resolution());
  tables_.assign(points_, blocks_, field, scoring.value_of_likelihood);
  roots_across_ = blocks_.blocks_of(blocks_.top());
  root_columns_ = summed_columns(roots_across_.count());
  root_rows_ = summed_rows(roots_across_.count(), root_columns_);
}

/// Makes the sums of the coarsest blocks at a group of rotations, row by row.
const std::uint32_t* LatticeSearch::sum_root(int group) {
  const std::size_t size = root_size();
  const std::size_t first = keeps_root_sums_ ? size * static_cast<std::size_t>(group) : 0;
  std::uint32_t* sums = memory_.sums.data() + first;
  const PointWindows windows =
      tables_.bounds(blocks_.top(), group, roots_across_.first, roots_across_.first);
  sum_windows(windows, root_rows_, root_columns_, sums);
  result_.look_ups += windows.count * size / kChildren;
  const auto count = static_cast<std::size_t>(roots_across_.count());
  result_.bounded += count * count;
  return sums;
}

/// Sums of the coarsest blocks, and what no pose of each of the largest groups of rotations scores
/// more than.
void LatticeSearch::bound_roots() {
  const int last = blocks_.last_group(blocks_.top());
  const int center = blocks_.group_of(blocks_.top(), 0);
  const std::size_t size = root_size();
  const auto groups = static_cast<std::size_t>(last + 1);
  keeps_root_sums_ = size * groups <= memory_.limits.sums;
  memory_.sums.resize(keeps_root_sums_ ? size * groups : size);
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
    const std::uint32_t* sums = sum_root(group);
    const int count = roots_across_.count();
    std::uint32_t most = 0;
    for (int row = 0; row < count; ++row, sums += root_columns_) {
      most = std::max(most, *std::max_element(sums, sums + count));
    }
    open_.push_back({most + blocks_.scan_of(blocks_.top()).unbounded -
                         penalty_.least(blocks_.thetas_of(blocks_.top(), group)),
                     blocks_.top() + 1, group});
  }
  std::make_heap(open_.begin(), open_.end());
}

void LatticeSearch::find_best() {
  if (tables_.empty()) {
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
  const StepRange all{-blocks_.lattice().half_xy, blocks_.lattice().half_xy};
  if (!result_.is_found || tables_.empty() || result_.bound > result_.score || result_.score <= 0 ||
      around_best.covers(all, all, {-blocks_.lattice().half_theta, blocks_.lattice().half_theta})) {
    return;
  }
  const auto least = static_cast<std::int64_t>(least_rival_ * static_cast<double>(result_.score));
  excluded_ = around_best;
  least_rival_ = 1.0;
  lead({result_.best, least});
  if (has_all_done_) {
    open_.insert(open_.end(), done_.begin(), done_.end());
    std::make_heap(open_.begin(), open_.end());
    done_.clear();
  } else {
    open_.clear();
    bound_roots();
  }
  const std::int64_t left = search_open();
  result_.rivals_left = std::max({std::int64_t{0}, left, passed_over_});
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
      const StepRange thetas = blocks_.thetas_of(blocks.level, blocks.group);
      for (int i = 0; i < static_cast<int>(kChildren); ++i) {
        const Node block = block_at(blocks, i);
        const StepRange x = blocks_.steps_of(block.level, block.x);
        const StepRange y = blocks_.steps_of(block.level, block.y);
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
    search(node);
  }
  return kNone;
}

void LatticeSearch::search(const Node& node) {
  if (is_excluded(node)) {
    return;
  }
  if (node.level > 0) {
    sum_within(node, [&](const Node& blocks, const BlockSums& sums) { add_blocks(blocks, sums); });
    return;
  }
  search_leaf(node);
  if (done_.size() < memory_.limits.open) {
    done_.push_back(node);
  } else {
    has_all_done_ = false;
  }
}

/// Sums of the blocks of the next finer level that are within a node, 4 x 4 at a time.
template <typename Visitor>
void LatticeSearch::sum_within(const Node& node, Visitor&& visit) {
  static_assert(summed_columns(kChildrenPerAxis) == kChildrenPerAxis &&
                summed_rows(kChildrenPerAxis, kChildrenPerAxis) == kChildrenPerAxis);
  if (node.level > blocks_.top()) {
    sum_within_root(node.group, visit);
    return;
  }
  Node blocks = node;
  blocks.level = node.level - 1;
  const int finer =
      LatticeBlocks::bounds_of(node.level).stride / LatticeBlocks::bounds_of(blocks.level).stride;
  blocks.x *= finer;
  blocks.y *= finer;
  const StepRange thetas = blocks_.thetas_of(node.level, node.group);
  const int turns = blocks_.scan_of(blocks.level).turns;
  BlockSums sums;
  for (int theta = thetas.first; theta <= thetas.last; theta += turns) {
    blocks.group = blocks_.group_of(blocks.level, theta);
    const PointWindows windows = tables_.bounds(blocks.level, blocks.group, blocks.x, blocks.y);
    sum_windows(windows, kChildrenPerAxis, kChildrenPerAxis, sums.data());
    result_.look_ups += windows.count;
    result_.bounded += kChildren;
    visit(blocks, sums);
  }
}

template <typename Visitor>
void LatticeSearch::sum_within_root(int group, Visitor&& visit) {
  const std::size_t size = root_size();
  const std::uint32_t* from = keeps_root_sums_
                                  ? memory_.sums.data() + size * static_cast<std::size_t>(group)
                                  : sum_root(group);
  BlockSums sums;
  for (int y = 0; y < roots_across_.count(); y += kChildrenPerAxis) {
    for (int x = 0; x < roots_across_.count(); x += kChildrenPerAxis) {
      for (int i = 0; i < static_cast<int>(kChildren); ++i) {
        const int row = std::min(y + i / kChildrenPerAxis, root_rows_ - 1);
        const int column = std::min(x + i % kChildrenPerAxis, root_columns_ - 1);
        sums[static_cast<std::size_t>(i)] = from[row * root_columns_ + column];
      }
      visit(Node{kNone, blocks_.top(), group, roots_across_.first + x, roots_across_.first + y},
            sums);
    }
  }
}

/// Adds those of 4 x 4 blocks that may be good enough: on level 1 together.
void LatticeSearch::add_blocks(const Node& blocks, const BlockSums& sums) {
  const std::int64_t unbounded = blocks_.scan_of(blocks.level).unbounded;
  const std::int64_t least = penalty_.least(blocks_.thetas_of(blocks.level, blocks.group));
  Node together = blocks;
  together.bound = kNone;
  together.blocks = 0;
  for (int i = 0; i < static_cast<int>(kChildren); ++i) {
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
  const StepRange x = blocks_.steps_of(block.level, block.x);
  const StepRange y = blocks_.steps_of(block.level, block.y);
  const StepRange thetas = blocks_.thetas_of(block.level, block.group);
  return x.count() <= 0 || y.count() <= 0 ? kNone : most - penalty_.least(x, y, thetas);
}

bool LatticeSearch::is_excluded(const Node& node) const {
  if (node.level > blocks_.top()) {
    return false;
  }
  const int last = node.level == 1 ? kChildrenPerAxis - 1 : 0;  // of the blocks along an axis
  const auto steps = [&](int first) -> StepRange {
    return {blocks_.steps_of(node.level, first).first,
            blocks_.steps_of(node.level, first + last).last};
  };
  return excluded_.covers(steps(node.x), steps(node.y), blocks_.thetas_of(node.level, node.group));
}

/// Where too many wait already, it is searched at once, deep before wide: more may be searched
/// then, but with the same answer.
void LatticeSearch::add(const Node& node) {
  if (node.bound == kNone || node.bound < wanted_) {
    return;
  }
  if (open_.size() < memory_.limits.open) {
    open_.push_back(node);
    std::push_heap(open_.begin(), open_.end());
  } else if (node.bound < leader_.score) {
    has_all_done_ = false;
  } else if (is_late()) {
    passed_over_ = std::max(passed_over_, node.bound);
  } else {
    search(node);
  }
}

/// All poses within one cell's width of translations. A point crosses into the next cell when its
/// step within the cell and the offset's add up to a cell; so the sums of four cells for each class
/// of points give the fit of every pose.
void LatticeSearch::search_leaf(const Node& block) {
  const int n = blocks_.lattice().steps_per_cell;
  const auto size = static_cast<std::size_t>(n);
  const int theta = blocks_.thetas_of(0, block.group).first;
  const SearchTables::Cells cells = tables_.cells(theta, block.x, block.y);
  result_.look_ups += cells.windows.count;
  std::vector<std::uint64_t>& of_class = memory_.of_class;
  of_class.assign(2 * size * size, 0);
  sum_corners(cells.windows, cells.classes, of_class.data());
  const StepRange steps_x = blocks_.steps_of(0, block.x);
  const StepRange steps_y = blocks_.steps_of(0, block.y);
  std::vector<std::int64_t>& of_row = memory_.of_row;
  of_row.resize(2 * size);
  for (int x = steps_x.first; x <= steps_x.last; ++x) {
    const int offset_x = x - block.x * n;
    for (int row = 0; row < n; ++row) {
      for (int crosses_y = 0; crosses_y < 2; ++crosses_y) {
        std::int64_t sum = 0;
        for (int column = 0; column < n; ++column) {
          const int pair = 2 * (row * n + column) + crosses_y;
          const unsigned half = column + offset_x >= n ? 32 : 0;
          sum += static_cast<std::uint32_t>(of_class[static_cast<std::size_t>(pair)] >> half);
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
                            const SearchDeadline& deadline, SearchMemory& memory) {
  LatticeSearch search(points, field, lattice, scoring, rivals ? rivals->least : 1.0, deadline,
                       memory.parts());
  search.find_best();
  if (rivals) {
    search.find_rival(*rivals);
  }
  memory.parts().let_go();
  return search.result();
}

SearchResult search_lattice(const std::vector<SearchPoint>& points, const LikelihoodField& field,
                            const SearchLattice& lattice, const SearchScoring& scoring,
                            const std::optional<RivalSearch>& rivals,
                            const SearchDeadline& deadline) {
  SearchMemory memory;
  return search_lattice(points, field, lattice, scoring, rivals, deadline, memory);
}

}  // namespace matchbox_slam
