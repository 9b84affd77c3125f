#include "matching/olson/window_search.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace matchbox_slam {
namespace {

constexpr double kFarthest = 1e4;  // [m], beyond any laser
constexpr int kMostSteps = 20000;  // of rotation to each side
constexpr int kMostCells = 2000;   // of translation to each side
constexpr double kTopLikelihood = 255.0;

/// Points of the scan that are searched as one.
class PointGroup {
 public:
  explicit PointGroup(const ScanPoint& first) : first_(first.position) { add(first); }

  /// @param spacing_square  [m^2]
  [[nodiscard]] bool takes(const ScanPoint& point, double spacing_square) const {
    return (point.position - first_).squaredNorm() < spacing_square;
  }

  void add(const ScanPoint& point) {
    sum_ += point.position;
    wall_ += point.weight;
    ++count_;
  }

  /// @param unit  length of wall of the weight 1 [m]; 0: every point has it.
  [[nodiscard]] SearchPoint merged(double unit) const {
    const double weight = unit > 0.0 ? wall_ / unit : count_;
    return {sum_ / count_, static_cast<int>(std::lround(
                               std::clamp(weight, 1.0, static_cast<double>(kMaxSearchWeight))))};
  }

 private:
  Eigen::Vector2d first_;
  Eigen::Vector2d sum_ = Eigen::Vector2d::Zero();
  double wall_ = 0.0;
  int count_ = 0;
};

/// The search adds up in 32 bits; so many points that their weights would not fit count less.
void limit_weights(std::vector<SearchPoint>& points) {
  double sum = 0.0;
  for (const SearchPoint& point : points) {
    sum += point.weight;
  }
  if (const double share = kMaxWeightSum / sum; share < 1.0) {
    for (SearchPoint& point : points) {
      point.weight = std::max(1, static_cast<int>(share * point.weight));
    }
  }
}

void find_search_points(const std::vector<ScanPoint>& points, const OlsonOptions& options,
                        std::vector<SearchPoint>& merged) {
  constexpr double kWallUnit = 0.00625;  // [m]; the usual cap of 0.1 m is 16 of them
  const double unit = options.weighting == "walls" ? kWallUnit : 0.0;
  const double spacing_square = options.point_spacing * options.point_spacing;
  merged.clear();
  std::optional<PointGroup> group;
  for (const ScanPoint& point : points) {
    if (!(point.position.squaredNorm() < kFarthest * kFarthest) || !std::isfinite(point.weight)) {
      continue;
    }
    if (group && group->takes(point, spacing_square)) {
      group->add(point);
      continue;
    }
    if (group) {
      merged.push_back(group->merged(unit));
    }
    group.emplace(point);
  }
  if (group) {
    merged.push_back(group->merged(unit));
  }
  limit_weights(merged);
}

/// Range below which nine tenths of the points lie [m]: a few far ones would make the steps of
/// rotation much finer for little.
/// @param squares  of ranges, on the way.
double useful_range(const std::vector<SearchPoint>& points, std::vector<double>& squares) {
  squares.clear();
  for (const SearchPoint& point : points) {
    squares.push_back(point.position.squaredNorm());
  }
  const auto rank = static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(squares.size() - 1));
  std::nth_element(squares.begin(), squares.begin() + rank, squares.end());
  return std::min(kFarthestPoint, std::sqrt(squares[static_cast<std::size_t>(rank)]));
}

int steps_in(double window, double step, int most = kMostSteps) {
  return static_cast<int>(std::min(std::ceil(window / step), static_cast<double>(most)));
}

/// How far to search to each side.
struct Window {
  double xy;        ///< [m]
  double theta;     ///< [rad]
  double asked_xy;  ///< [m], by prior or configuration
};

Window make_window(const MatchProblem& problem, const OlsonOptions& options) {
  const Eigen::Vector3d sigmas = problem.searched_covariance().diagonal().cwiseMax(0.0).cwiseSqrt();
  const double xy = options.window_sigmas * std::max(sigmas.x(), sigmas.y());
  const double theta = options.window_sigmas * sigmas.z();
  return {options.window_xy > 0.0 ? options.window_xy : std::min(options.max_window_xy, xy),
          std::min(kPi, options.window_theta > 0.0 ? options.window_theta : theta),
          options.window_xy > 0.0 ? options.window_xy : xy};
}

SearchLattice make_lattice(const MatchProblem& problem, const Window& window, double range,
                           const OlsonOptions& options) {
  const double resolution = problem.field.geometry().resolution();
  SearchLattice lattice;
  lattice.center = problem.predicted_map_from_base;
  lattice.steps_per_cell =
      std::clamp(static_cast<int>(std::ceil(resolution / options.step_xy - 1e-9)), 1, 16);
  const double step = lattice.step_xy(resolution);
  // The chord of the useful range; the farthest step still turns less than a quarter.
  lattice.step_theta = options.step_theta > 0.0
                           ? options.step_theta
                           : 2.0 * std::asin(std::min(0.7, 0.5 * step / std::max(range, step)));
  lattice.step_theta = std::max(lattice.step_theta, window.theta / kMostSteps);
  lattice.half_xy = steps_in(window.xy, step, kMostCells * lattice.steps_per_cell);
  lattice.half_theta = steps_in(window.theta, lattice.step_theta);
  return lattice;
}

SearchScoring make_scoring(const MatchProblem& problem, double top, const OlsonOptions& options) {
  SearchScoring scoring;
  const double floor = options.outliers;
  for (std::size_t i = 0; i < scoring.value_of_likelihood.size(); ++i) {
    const double likelihood = static_cast<double>(i) / kTopLikelihood;
    const double value = options.likelihood == "log"
                             ? 1.0 - std::log(floor + (1.0 - floor) * likelihood) / std::log(floor)
                             : likelihood;
    scoring.value_of_likelihood[i] =
        static_cast<std::uint8_t>(std::lround(kTopLikelihood * std::clamp(value, 0.0, 1.0)));
  }
  scoring.prior_information = prior_information(problem.searched_covariance());
  scoring.prior_weight = top * weight_beside(problem.scan, options.prior_weight);
  if (options.search_floor > 0.0) {
    scoring.floor = static_cast<std::int64_t>(options.search_floor * top) - 1;
  }
  return scoring;
}

/// Beyond a whole turn, or where the prior leaves one pose alone, there is no edge.
bool is_on_edge(const LatticePose& pose, const SearchLattice& lattice) {
  const bool on_xy =
      lattice.half_xy > 0 && std::max(std::abs(pose.x), std::abs(pose.y)) == lattice.half_xy;
  const bool on_theta = lattice.half_theta > 0 && std::abs(pose.theta) == lattice.half_theta &&
                        lattice.half_theta < steps_in(kPi, lattice.step_theta);
  return on_xy || on_theta;
}

/// How likely a coordinate with this standard deviation lies within the one limit to each side, but
/// not within the other, narrower one.
double share_between(double within, double not_within, double sigma) {
  return std::erf(within / (sigma * std::sqrt(2.0))) -
         std::erf(not_within / (sigma * std::sqrt(2.0)));
}

SearchDeadline deadline_of(const OlsonOptions& options) {
  using Clock = std::chrono::steady_clock;
  SearchDeadline deadline;
  if (options.deadline > 0.0) {
    deadline.time = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                       std::chrono::duration<double>(options.deadline));
  }
  if (options.most_look_ups > 0) {
    deadline.look_ups = static_cast<std::size_t>(options.most_look_ups);
  }
  return deadline;
}

/// In metres and shares.
/// @param top  the highest score.
void tell(const MatchProblem& problem, const Window& window, double top,
          const SearchLattice& lattice, const SearchResult& result, FoundInWindow& found) {
  found.is_any = result.is_found;
  found.candidates = result.candidates;
  found.proof.remaining_bound = static_cast<double>(result.bound) / top;
  if (!result.is_found) {
    return;
  }
  const double resolution = problem.field.geometry().resolution();
  found.step_xy = lattice.step_xy(resolution);
  found.step_theta = lattice.step_theta;
  found.proof.map_from_base = pose_at(lattice, result.best, resolution);
  found.proof.best_score = static_cast<double>(result.score) / top;
  found.proof.on_edge = is_on_edge(result.best, lattice);
  const double searched_xy = lattice.half_xy * found.step_xy;
  if (searched_xy < (1.0 - 1e-9) * window.asked_xy) {
    found.proof.clipped = true;
    const double variance = problem.searched_covariance().diagonal().head<2>().maxCoeff();
    found.share_beyond = share_between(window.asked_xy, searched_xy, std::sqrt(variance));
  }
  if (result.rival) {
    found.rival = pose_at(lattice, result.rival->pose, resolution);
  }
  if (const std::int64_t rival =
          std::max(result.rivals_left, result.rival ? result.rival->score : 0);
      rival > 0) {
    found.rival_share =
        std::min(1.0, static_cast<double>(rival) / static_cast<double>(result.score));
  }
}

}  // namespace

FoundInWindow find_in_window(const MatchProblem& problem, const OlsonOptions& options,
                             WindowSearchMemory& memory) {
  find_search_points(problem.scan.points, options, memory.points);
  const std::vector<SearchPoint>& points = memory.points;
  FoundInWindow found;
  found.proof.map_from_base = problem.predicted_map_from_base;
  if (points.empty()) {
    return found;
  }
  double top = 0.0;
  for (const SearchPoint& point : points) {
    top += kTopLikelihood * point.weight;
  }
  const double range = useful_range(points, memory.squares);
  const double resolution = problem.field.geometry().resolution();
  const Window window = make_window(problem, options);
  const SearchLattice lattice = make_lattice(problem, window, range, options);
  const double far = std::max(range, options.rival_distance);
  const RivalSearch rivals{steps_in(options.rival_distance, lattice.step_xy(resolution)),
                           steps_in(options.rival_distance / far, lattice.step_theta),
                           options.least_rival};
  const SearchResult result =
      search_lattice(points, problem.field, lattice, make_scoring(problem, top, options), rivals,
                     deadline_of(options), memory.search);
  tell(problem, window, top, lattice, result, found);
  return found;
}

}  // namespace matchbox_slam
