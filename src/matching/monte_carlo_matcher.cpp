#include "matchbox_slam/matching/monte_carlo_matcher.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

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

Pose2 moved(const Pose2& pose, const Eigen::Vector3d& by) {
  return {pose.x + by.x(), pose.y + by.y(), wrap_angle(pose.theta + by.z())};
}

/// About `count` of the points, one for each equal length of wall.
std::vector<Eigen::Vector2f> spread_along_walls(const std::vector<ScanPoint>& points, int count) {
  double total = 0.0;
  for (const ScanPoint& point : points) {
    total += point.weight;
  }
  const double stride = total / count;
  std::vector<Eigen::Vector2f> chosen;
  chosen.reserve(static_cast<std::size_t>(count) + 1);
  double next = 0.5 * stride;
  double passed = 0.0;
  for (const ScanPoint& point : points) {
    passed += point.weight;
    if (passed >= next) {
      chosen.emplace_back(point.position.cast<float>());
      next += stride * std::max(1.0, std::ceil((passed - next) / stride));
    }
  }
  return chosen;
}

/// The search's score of a pose: the mean over the points of a value that falls with the distance to
/// the nearest wall, less what the pose is off the prediction.
class SearchScore {
 public:
  SearchScore(const MatchProblem& problem, const MonteCarloOptions& options)
      : field_(problem.field),
        points_(spread_along_walls(problem.scan.points, options.search_points)),
        prior_weight_(options.prior_weight) {
    const double sigma = problem.field.options().sigma;
    const double reach = problem.field.options().reach;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double distance = static_cast<double>(i) / 255.0 * reach;
      const double gauss = std::exp(-0.5 * distance * distance / (sigma * sigma));
      const double slope = 1.0 - distance / reach;
      const double value = (1.0 - options.slope_share) * gauss + options.slope_share * slope;
      values_[i] = static_cast<std::int32_t>(std::lround(kTop * value));
    }
    values_[LikelihoodField::kFar] = 0;
  }

  /// Score of a pose `sigmas` away from the prediction, in standard deviations. Gives up and returns
  /// something not above `to_beat` once the pose cannot beat it any more.
  [[nodiscard]] double operator()(const Pose2& map_from_base, double sigmas_square,
                                  double to_beat) const {
    const auto count = static_cast<std::int64_t>(points_.size());
    const double penalty = prior_weight_ * sigmas_square;
    const double needed_fit = (to_beat + penalty) * static_cast<double>(kTop * count);
    if (needed_fit >= static_cast<double>(kTop * count)) {
      return to_beat;
    }
    const auto needed = static_cast<std::int64_t>(std::floor(needed_fit));
    const double per_metre = 1.0 / field_.geometry().resolution();
    const Cell base = field_.geometry().cell_at(map_from_base.translation());
    // Relative to the base's cell, single precision is exact enough anywhere in the map.
    const auto x0 = static_cast<float>(map_from_base.x * per_metre - base.x) + kPositive;
    const auto y0 = static_cast<float>(map_from_base.y * per_metre - base.y) + kPositive;
    const auto c = static_cast<float>(std::cos(map_from_base.theta) * per_metre);
    const auto s = static_cast<float>(std::sin(map_from_base.theta) * per_metre);
    constexpr std::int64_t kStretch = 32;
    std::int64_t sum = 0;
    for (std::int64_t first = 0; first < count; first += kStretch) {
      const std::int64_t last = std::min(first + kStretch, count);
      for (std::int64_t i = first; i < last; ++i) {
        const Eigen::Vector2f& point = points_[static_cast<std::size_t>(i)];
        const Cell cell{
            base.x - kShift + static_cast<int>(x0 + (c * point.x() - s * point.y())),
            base.y - kShift + static_cast<int>(y0 + (s * point.x() + c * point.y()))};
        sum += values_[field_.distance(cell)];
      }
      if (sum + (count - last) * kTop <= needed) {
        return to_beat;
      }
    }
    return static_cast<double>(sum) / static_cast<double>(kTop * count) - penalty;
  }

 private:
  static constexpr std::int32_t kTop = 4096;
  // Truncation rounds down only what is positive. 2^15 cells are farther than any laser sees.
  static constexpr int kShift = 1 << 15;
  static constexpr float kPositive = static_cast<float>(kShift);

  const LikelihoodField& field_;
  std::vector<Eigen::Vector2f> points_;
  double prior_weight_;
  std::array<std::int32_t, 256> values_{};
};

/// The paper's algorithm 1. Returns the best pose and adds up the tries.
Pose2 random_search(const MatchProblem& problem, const MonteCarloOptions& options, Random& random,
                    std::size_t& tries) {
  const SearchScore score(problem, options);
  const Eigen::Matrix3d spread = square_root(problem.prior_covariance);
  // The pose as steps in standard deviations of the prior, away from the prediction.
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double best_score = score(problem.predicted_map_from_base, 0.0, -1e9);
  double area = options.first_area;
  int failed = 0;
  int made = 0;
  while (made < options.max_tries && failed < options.max_failed_tries) {
    ++made;
    const Eigen::Vector3d candidate = best + area * gaussian_vector(random);
    const double candidate_score =
        score(moved(problem.predicted_map_from_base, spread * candidate), candidate.squaredNorm(),
              best_score);
    if (candidate_score > best_score) {
      best = candidate;
      best_score = candidate_score;
      area *= options.narrowing;
      if (options.reset_on_success) {
        failed = 0;
      }
      continue;
    }
    ++failed;
    if (options.halve_after > 0 && failed % options.halve_after == 0) {
      area *= 0.5;
    }
  }
  tries += static_cast<std::size_t>(made) + 1;
  return moved(problem.predicted_map_from_base, spread * best);
}

/// Second moment of the posterior around `center`, by importance sampling: poses are drawn with twice
/// the spread of the curvature's Gaussian and weighted by their score over the density of the draw.
Eigen::Matrix3d sampled_covariance(const MatchProblem& problem, const RefinedPose& center,
                                   const MonteCarloOptions& options, Random& random) {
  constexpr double kWider = 2.0;
  const LocalPosterior posterior(problem.scan.points, problem.field, center.map_from_base,
                                 {problem.predicted_map_from_base, problem.prior_covariance},
                                 options.refinement);
  const Eigen::Matrix3d spread = kWider * square_root(center.covariance);
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double total = 0.0;
  for (int i = 0; i < options.covariance_samples; ++i) {
    const Eigen::Vector3d draw = gaussian_vector(random);
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d step = side * (spread * draw);
      const double log_weight = 0.5 * draw.squaredNorm() - posterior.cost(step);
      const double weight = std::exp(std::min(log_weight, 30.0));
      moment += weight * step * step.transpose();
      total += weight;
    }
  }
  return total > 0.0 ? Eigen::Matrix3d(moment / total) : center.covariance;
}

}  // namespace

void MonteCarloMatcher::configure(const Parameters& parameters) {
  options_ = read_options<MonteCarloOptions>(parameters, "monte_carlo");
}

std::vector<OptionDescription> MonteCarloMatcher::options() const {
  return describe_options(options_);
}

MatchResult MonteCarloMatcher::match(const MatchProblem& problem) const {
  if (!is_valid_prior(problem)) {
    return rejected(problem, MatchStatus::kRejectedInvalidPrior);
  }
  if (problem.scan.points.empty()) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  if (problem.field.empty()) {
    return rejected(problem, MatchStatus::kRejectedNoReference);
  }
  Random random(problem.seed);
  std::size_t tries = 0;
  const Pose2 found = random_search(problem, options_, random, tries);
  const RefinedPose refined =
      refine(problem.scan.points, problem.field, found,
             {problem.predicted_map_from_base, problem.prior_covariance}, options_.refinement);
  if (refined.score < options_.min_score) {
    MatchResult result = rejected(problem, MatchStatus::kRejectedLowScore);
    result.score = refined.score;
    result.candidates = tries;
    return result;
  }
  MatchResult result;
  result.status = MatchStatus::kAccepted;
  result.map_from_base = refined.map_from_base;
  result.covariance = options_.covariance_samples > 0
                          ? sampled_covariance(problem, refined, options_, random)
                          : refined.covariance;
  result.score = std::clamp(refined.score, 0.0, 1.0);
  result.unconstrained_directions = refined.unconstrained_directions;
  result.candidates = tries;
  return result;
}

}  // namespace matchbox_slam
