#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"

namespace matchbox_slam {

/// A point of the scan as the search sees it.
struct SearchPoint {
  Eigen::Vector2d position;  ///< [m], base frame; less than 1e5 m away
  int weight = 1;            ///< 1...kMaxSearchWeight
};

constexpr int kMaxSearchWeight = 64;

/// The weights of a scan's points add up to this at most.
constexpr double kMaxWeightSum = 16e6;

/// The poses that are searched: rotations and translations by whole steps from the center, up to as
/// many steps to each side. Steps of translation are cells divided by a whole number, so that all
/// of the search is done in integers.
struct SearchLattice {
  Pose2 center;             ///< map from base
  int steps_per_cell = 1;   ///< 1...16
  int half_xy = 0;          ///< steps to each side along x, and along y; 0...2000 cells
  int half_theta = 0;       ///< steps to each side in rotation; 0...20000
  double step_theta = 0.0;  ///< [rad]

  [[nodiscard]] double step_xy(double resolution) const { return resolution / steps_per_cell; }
};

/// One pose of the lattice, in steps from its center.
struct LatticePose {
  int x = 0;
  int y = 0;
  int theta = 0;
};

[[nodiscard]] Pose2 pose_at(const SearchLattice& lattice, const LatticePose& at, double resolution);

/// What the search maximises: the sum over the points of weight times value of the cell that the
/// point falls into, less a penalty for the distance from the center, in whole numbers.
struct SearchScoring {
  /// Value of each likelihood of the field; must not fall from 0 to 255, and begins with 0.
  std::array<std::uint8_t, 256> value_of_likelihood;
  /// What a pose d = (dx, dy, dtheta) away from the center loses: prior_weight times
  /// prior_penalty(d^T prior_information d), rounded, up to kMaxPenalty. Symmetric, positive
  /// semidefinite.
  Eigen::Matrix3d prior_information = Eigen::Matrix3d::Zero();
  double prior_weight = 0.0;
  /// Poses that score no more than this are not looked for.
  std::int64_t floor = std::numeric_limits<std::int64_t>::min();
};

constexpr std::int64_t kTopValue = 255;  ///< of a cell

/// A pose this improbable is never the answer but for want of any other.
constexpr std::int64_t kMaxPenalty = std::int64_t{1} << 40;

/// Poses that differ from the best one by more than this, along one coordinate at least, are rivals
/// of it, and not its shoulders.
struct RivalSearch {
  int xy = 0;          ///< steps
  int theta = 0;       ///< steps
  double least = 0.0;  ///< share of the best score below which nothing is a rival, 0...1
};

/// A distant pose that is nearly as good.
struct Rival {
  LatticePose pose;
  std::int64_t score = 0;
};

/// The best pose, and what is known about it.
struct SearchResult {
  bool is_found = false;  ///< else nothing scores more than the floor
  LatticePose best;
  std::int64_t score = 0;
  /// Nothing on the lattice scores more than this; the score itself when the search was not ended
  /// by its deadline.
  std::int64_t bound = 0;
  std::size_t candidates = 0;  ///< poses whose score was computed
  std::size_t bounded = 0;     ///< blocks of poses whose bound was computed
  std::size_t look_ups = 0;    ///< of points, as of SearchDeadline
  std::optional<Rival> rival;  ///< the best one, where one was asked for and found in time
  /// What rivals that there was no time to look for score at most; 0: there was time.
  std::int64_t rivals_left = 0;
};

/// When to give up; by default never.
struct SearchDeadline {
  std::optional<std::chrono::steady_clock::time_point> time;
  /// Of points, each in up to 16 blocks or cells at once: the same on all machines, and each takes
  /// some nanoseconds.
  std::size_t look_ups = std::numeric_limits<std::size_t>::max();
};

/// The search sees the map no farther than this to each side of the center, to bound its memory.
constexpr int kFarthestCells = 6000;

/// What bounds the memory of a search, besides tables of the field in reach. Beyond these the
/// answer is the same, but takes longer.
struct SearchLimits {
  std::size_t open = std::size_t{1} << 20;  ///< blocks that wait, and leaves kept; 32 bytes each
  std::size_t sums = std::size_t{1} << 24;  ///< of the coarsest blocks that are kept; 4 bytes each
};

/// What a search works in, kept from one to the next but for what only a large one needs; what it
/// holds never matters.
class SearchMemory {
 public:
  explicit SearchMemory(const SearchLimits& limits = {});
  SearchMemory(SearchMemory&& other) noexcept;
  SearchMemory& operator=(SearchMemory&& other) noexcept;
  ~SearchMemory();

  struct Parts;
  [[nodiscard]] Parts& parts() { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

/// Finds the best pose of the lattice, the same as trying every one: best first over groups of
/// rotations with blocks of translations, in up to four resolutions of both, of the points
/// (ScanLevel) and of the field (FieldWindow), pruned by a valid bound less the least penalty. Of
/// equal scores the pose with the smaller rotation wins, then the smaller |x| + |y|, then the
/// smaller theta, y, x. (Olson, "Real-Time Correlative Scan Matching", ICRA 2009; bounds at full
/// resolution as by Hess et al., ICRA 2016; those over rotations as by Yang et al., "Go-ICP",
/// 2016.)
///
/// A point at p falls into the cell floor((floor(q n / r) + i) / n) along x: q is the x of the
/// point moved by the center's position and the rotation's angle, r the edge of a cell, n the steps
/// per cell and i the offset in steps; likewise along y. Cells more than kFarthestCells away from
/// the center, or from the map's origin more than 2^30 steps, are worth nothing. Cost: besides the
/// sums, a copy of the field in reach of the points.
[[nodiscard]] SearchResult search_lattice(const std::vector<SearchPoint>& points,
                                          const LikelihoodField& field,
                                          const SearchLattice& lattice,
                                          const SearchScoring& scoring,
                                          const std::optional<RivalSearch>& rivals,
                                          const SearchDeadline& deadline, SearchMemory& memory);
[[nodiscard]] SearchResult search_lattice(const std::vector<SearchPoint>& points,
                                          const LikelihoodField& field,
                                          const SearchLattice& lattice,
                                          const SearchScoring& scoring,
                                          const std::optional<RivalSearch>& rivals = {},
                                          const SearchDeadline& deadline = {});

}  // namespace matchbox_slam
