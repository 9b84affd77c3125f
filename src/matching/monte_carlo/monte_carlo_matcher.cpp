#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// A matrix A with A A^T = covariance, also for one that is only semidefinite.
Eigen::Matrix3d square_root(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Eigen::Vector3d gaussian_vector(Random& random) {
  const double x = random.gaussian();
  const double y = random.gaussian();
  return {x, y, random.gaussian()};
}

/// About `count` of the points, one for each equal length of wall, shuffled by a fixed stride so
/// that the first few already speak for all.
std::vector<Eigen::Vector2f> spread_along_walls(const std::vector<ScanPoint>& points, int count) {
  constexpr double kFarthestMatched = 1e4;  // [m], beyond any laser; NaN is not below it either
  const auto weight = [](const ScanPoint& point) {
    return point.position.norm() < kFarthestMatched && point.weight > 0.0 ? point.weight : 0.0;
  };
  double total = 0.0;
  for (const ScanPoint& point : points) {
    total += weight(point);
  }
  const double stride = total / count;
  std::vector<Eigen::Vector2f> chosen;
  double next = 0.5 * stride;
  double passed = 0.0;
  for (const ScanPoint& point : points) {
    if (!(weight(point) > 0.0)) {
      continue;
    }
    passed += weight(point);
    if (passed >= next) {
      chosen.emplace_back(point.position.cast<float>());
      next += stride * std::max(1.0, std::ceil((passed - next) / stride));
    }
  }
  std::vector<Eigen::Vector2f> shuffled;
  shuffled.reserve(chosen.size());
  constexpr std::size_t kStride = 16;
  for (std::size_t first = 0; first < kStride; ++first) {
    for (std::size_t i = first; i < chosen.size(); i += kStride) {
      shuffled.push_back(chosen[i]);
    }
  }
  return shuffled;
}

/// The tiles of the field around one place, for look-ups without questions: where the field has no
/// tile stands one that is far from everything.
class TilesAround {
 public:
  using Distances = std::array<std::uint8_t, LikelihoodField::Tile::kCells>;

  /// @param box  cells that can be looked up.
  TilesAround(const LikelihoodField& field, const CellBox& box) {
    far_.fill(LikelihoodField::kFar);
    const Cell first = LikelihoodField::Tiles::tile_of(box.min);
    const Cell last = LikelihoodField::Tiles::tile_of(box.max);
    corner_ = {first.x * kSize, first.y * kSize};
    columns_ = static_cast<unsigned>(last.x - first.x + 1);
    rows_ = static_cast<unsigned>(last.y - first.y + 1);
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const LikelihoodField::Tile* tile = field.tiles().find({x, y});
        tiles_.push_back(tile == nullptr ? &far_ : &tile->distance);
      }
    }
  }
  TilesAround(const TilesAround&) = delete;
  TilesAround& operator=(const TilesAround&) = delete;

  /// Lower left corner of all that can be looked up.
  [[nodiscard]] const Cell& corner() const { return corner_; }

  /// @param x, y  cells from the corner; may lie anywhere.
  [[nodiscard]] std::uint8_t distance(int x, int y) const {
    const auto column = static_cast<unsigned>(x >> kBits);
    const auto row = static_cast<unsigned>(y >> kBits);
    if (column >= columns_ || row >= rows_) {
      return LikelihoodField::kFar;
    }
    return (*tiles_[row * columns_ + column])[LikelihoodField::Tiles::index_in_tile({x, y})];
  }

 private:
  static constexpr int kBits = LikelihoodField::Tiles::kTileBits;
  static constexpr int kSize = LikelihoodField::Tiles::kTileSize;

  Distances far_;
  Cell corner_;
  unsigned columns_ = 0;
  unsigned rows_ = 0;
  std::vector<const Distances*> tiles_;
};

/// Cells that the points can fall into while the pose stays within a few standard deviations.
CellBox cells_in_reach(const MatchProblem& problem, const std::vector<Eigen::Vector2f>& points) {
  constexpr double kSigmas = 4.0;      // what falls outside counts as far from every wall
  constexpr double kMaxReach = 200.0;  // [m], for any width of the prior; twice what lasers reach
  float farthest = 0.0F;
  for (const Eigen::Vector2f& point : points) {
    farthest = std::max(farthest, point.squaredNorm());
  }
  const Eigen::Vector3d sigmas = problem.searched_covariance().diagonal().cwiseMax(0.0).cwiseSqrt();
  const double reach = std::min(kMaxReach, std::sqrt(static_cast<double>(farthest)) +
                                               kSigmas * std::max(sigmas.x(), sigmas.y()));
  const Eigen::Vector2d center = problem.predicted_map_from_base.translation();
  const Eigen::Vector2d margin(reach, reach);
  const GridGeometry& geometry = problem.field.geometry();
  return {geometry.cell_at(center - margin), geometry.cell_at(center + margin)};
}

/// The search's score of a pose: the mean over the points of a value that falls with the distance
/// to the nearest wall, less what the pose is off the prediction.
class SearchScore {
 public:
  SearchScore(const MatchProblem& problem, const MonteCarloOptions& options)
      : points_(spread_along_walls(problem.scan.points, options.search_points)),
        tiles_(problem.field, cells_in_reach(problem, points_)),
        cells_per_metre_(1.0 / problem.field.geometry().resolution()),
        prior_weight_(weight_beside(problem.scan, options.prior_weight)) {
    const double sigma = problem.field.options().sigma;
    const double reach = problem.field.options().reach;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double distance = static_cast<double>(i) / 255.0 * reach;
      const double gauss = std::exp(-0.5 * distance * distance / (sigma * sigma));
      const double slope = 1.0 - distance / reach;
      const double value = (1.0 - options.slope_share) * gauss + options.slope_share * slope;
      values_[i] = static_cast<std::int32_t>(std::lround(kLargestValue * value));
    }
    values_[LikelihoodField::kFar] = 0;
  }

  /// Score of a pose whose squared distance from the prediction is given in standard deviations.
  /// Gives up and returns `to_beat` as soon as the pose cannot beat it any more.
  [[nodiscard]] double operator()(const Pose2& map_from_base, double sigmas_square,
                                  double to_beat) const {
    const auto count = static_cast<std::int32_t>(points_.size());
    const double top = static_cast<double>(kLargestValue) * count;
    const double penalty = prior_weight_ * prior_penalty(sigmas_square);
    const double needed_fit = (to_beat + penalty) * top;
    if (!(needed_fit < top)) {
      return to_beat;
    }
    const auto needed = static_cast<std::int32_t>(std::max(-1.0, std::floor(needed_fit)));
    // Relative to the corner, single precision is exact enough anywhere in the map. Truncation
    // rounds down only what is positive, hence the shift; 2^14 cells are farther than any laser
    // sees.
    constexpr int kShift = 1 << 14;
    const auto x0 =
        static_cast<float>(map_from_base.x * cells_per_metre_ - tiles_.corner().x + kShift);
    const auto y0 =
        static_cast<float>(map_from_base.y * cells_per_metre_ - tiles_.corner().y + kShift);
    // A prior may be as wide as it likes, but cells are counted in integers.
    constexpr float kFarthestShift = 1e6F;
    if (!(std::abs(x0) < kFarthestShift && std::abs(y0) < kFarthestShift)) {
      return to_beat;
    }
    const auto c = static_cast<float>(std::cos(map_from_base.theta) * cells_per_metre_);
    const auto s = static_cast<float>(std::sin(map_from_base.theta) * cells_per_metre_);
    constexpr std::int32_t kStretch = 24;
    std::int32_t sum = 0;
    for (std::int32_t first = 0; first < count; first += kStretch) {
      const std::int32_t last = std::min(first + kStretch, count);
      for (std::int32_t i = first; i < last; ++i) {
        const Eigen::Vector2f& point = points_[static_cast<std::size_t>(i)];
        const int x = static_cast<int>(x0 + (c * point.x() - s * point.y())) - kShift;
        const int y = static_cast<int>(y0 + (s * point.x() + c * point.y())) - kShift;
        sum += values_[tiles_.distance(x, y)];
      }
      if (sum + (count - last) * kLargestValue <= needed) {
        return to_beat;
      }
    }
    return static_cast<double>(sum) / top - penalty;
  }

 private:
  static constexpr std::int32_t kLargestValue = 1024;  // with a million points the sum still fits

  std::vector<Eigen::Vector2f> points_;
  TilesAround tiles_;
  double cells_per_metre_;
  double prior_weight_;
  std::array<std::int32_t, 256> values_{};
};

/// Covariance of the search's answer: it knows no pose better than to a cell of the field, nor a
/// heading better than what moves the points, by the root of their mean squared range, as far.
Eigen::Matrix3d search_covariance(const MatchProblem& problem) {
  const double cell = problem.field.geometry().resolution();
  double squares = 0.0;
  double count = 0.0;
  for (const ScanPoint& point : problem.scan.points) {
    if (point.position.allFinite()) {
      squares += point.position.squaredNorm();
      ++count;
    }
  }
  return step_covariance(cell, cell / std::sqrt(std::max(cell * cell, squares / count)));
}

/// The best pose of a search, as steps away from the prediction in standard deviations of the
/// prior.
struct Found {
  Eigen::Vector3d steps = Eigen::Vector3d::Zero();
  double score = 0.0;
  int tries = 0;
};

/// Algorithm 1 of "The Scan Matchers Research and Comparison", from the prediction on.
Found random_search(const MatchProblem& problem, const MonteCarloOptions& options,
                    const SearchScore& score, const Eigen::Matrix3d& spread, int most_tries,
                    Random& random) {
  Found best;
  best.score = score(problem.predicted_map_from_base, 0.0, -1e9);
  double area = options.first_area;
  int failed = 0;
  while (best.tries < most_tries && failed < options.max_failed_tries) {
    ++best.tries;
    const Eigen::Vector3d candidate = best.steps + area * gaussian_vector(random);
    const double candidate_score =
        score(displaced(problem.predicted_map_from_base, spread * candidate),
              candidate.squaredNorm(), best.score);
    if (candidate_score > best.score) {
      best.steps = candidate;
      best.score = candidate_score;
      area *= options.narrowing;
      failed = options.reset_on_success ? 0 : failed;
      continue;
    }
    ++failed;
    if (options.halve_after > 0 && failed % options.halve_after == 0) {
      area *= 0.5;
    }
  }
  return best;
}

/// Searches again from the prediction until a pose fits well or no tries are left; keeps the best.
Found repeated_search(const MatchProblem& problem, const MonteCarloOptions& options,
                      Random& random) {
  const SearchScore score(problem, options);
  const Eigen::Matrix3d spread = square_root(problem.searched_covariance());
  Found best;
  int tries = 0;
  do {
    const Found found =
        random_search(problem, options, score, spread, options.max_tries - tries, random);
    if (tries == 0 || found.score > best.score) {
      best = found;
    }
    tries += found.tries;
  } while (best.score < options.enough_score && tries < options.max_tries);
  best.tries = tries;
  best.steps = spread * best.steps;
  return best;
}

/// Second moment of the posterior around `center`, by importance sampling: poses are drawn with
/// twice the spread of the curvature's Gaussian and weighted by their score over the density of the
/// draw.
Eigen::Matrix3d sampled_covariance(const LocalPosterior& posterior,
                                   const Eigen::Matrix3d& covariance, int samples, Random& random) {
  // Wider than the posterior, so that no draw has a weight that rules the sum. The mean
  // NEES of pairs in rooms, 3 if honest, is 3.6; with 1.2 it is 3.5, with 4 it is 12.
  constexpr double kSpreadFactor = 2.0;
  const Eigen::Matrix3d spread = kSpreadFactor * square_root(covariance);
  std::vector<Eigen::Vector3d> draws;
  std::vector<Eigen::Vector3d> steps;
  for (int i = 0; i < samples; ++i) {
    draws.push_back(gaussian_vector(random));
    steps.emplace_back(spread * draws.back());
  }
  std::vector<std::array<double, 2>> costs;
  posterior.costs_of_both(steps, costs);
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (const double cost : costs[i]) {
      const double weight = std::exp(std::min(0.5 * draws[i].squaredNorm() - cost, 30.0));
      moment += weight * steps[i] * steps[i].transpose();
      total += weight;
    }
  }
  return total > 0.0 ? Eigen::Matrix3d(moment / total) : covariance;
}

}  // namespace

void MonteCarloMatcher::configure(const Parameters& parameters) {
  options_ = read_options<MonteCarloOptions>(parameters, "monte_carlo");
}

std::vector<OptionDescription> MonteCarloMatcher::options() const {
  return describe_options(options_);
}

MatchResult MonteCarloMatcher::match(const MatchProblem& problem) const {
  if (const std::optional<MatchResult> rejection = reject_unmatchable(problem)) {
    return *rejection;
  }
  Random random(problem.seed);
  const Found found = repeated_search(problem, options_, random);
  const auto tries = static_cast<std::size_t>(found.tries);
  const Pose2 start = displaced(problem.predicted_map_from_base, found.steps);
  const PosePrior prior{problem.predicted_map_from_base, problem.prior_covariance};
  Correspondences pairs(problem.scan.points, problem.field, start);
  const RefinedPose refined = refine(pairs, start, prior, options_.refinement);
  if (!(refined.score >= options_.min_score)) {
    MatchResult result = rejected(problem, MatchStatus::kRejectedLowScore);
    result.score = refined.score;
    result.candidates = tries;
    return result;
  }
  MatchResult result;
  result.status = MatchStatus::kAccepted;
  result.map_from_base = refined.map_from_base;
  result.refined_by = difference(refined.map_from_base, start);
  // Along a direction that nothing holds, samples would only add noise to the prior's variance.
  const bool sampled = options_.covariance_samples > 0 && refined.unconstrained_directions.empty();
  result.covariance =
      sampled ? sampled_covariance({pairs, refined.map_from_base, prior, options_.refinement},
                                   refined.covariance, options_.covariance_samples, random)
              : refined.covariance;
  if (options_.refinement.iterations == 0) {
    result.covariance += search_covariance(problem);
  }
  result.score = std::clamp(refined.score, 0.0, 1.0);
  result.unconstrained_directions = refined.unconstrained_directions;
  result.candidates = tries;
  return result;
}

}  // namespace matchbox_slam
