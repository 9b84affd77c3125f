#include "evaluation/pair_statistics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace matchbox_slam {
namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// An error over (x, y, theta) along the axes of the true pose.
Eigen::Vector3d turned_to_base(const Eigen::Vector3d& error, const Pose2& truth) {
  const Eigen::Vector2d along = Pose2{0.0, 0.0, -truth.theta} * Eigen::Vector2d(error.head<2>());
  return {along.x(), along.y(), error.z()};
}

/// None when the covariance is not positive definite.
std::optional<double> squared_in_units_of(const Eigen::Matrix3d& covariance,
                                          const Eigen::Vector3d& error) {
  const Eigen::LLT<Eigen::Matrix3d> root(covariance);
  if (!covariance.allFinite() || root.info() != Eigen::Success) {
    return std::nullopt;
  }
  const double square = error.dot(root.solve(error));
  return std::isfinite(square) ? std::optional(square) : std::nullopt;
}

/// The bound in the median over all pairs.
BoundStatistics median_bound(const std::vector<Eigen::Matrix3d>& information) {
  constexpr double kOpen = std::numeric_limits<double>::infinity();
  std::vector<double> translations;
  std::vector<double> headings;
  for (const Eigen::Matrix3d& matrix : information) {
    const Eigen::FullPivLU<Eigen::Matrix3d> solver(matrix);
    const Eigen::Matrix3d bound = solver.isInvertible()
                                      ? Eigen::Matrix3d(solver.inverse())
                                      : Eigen::Matrix3d(Eigen::Matrix3d::Constant(kOpen));
    translations.push_back(std::sqrt(bound(0, 0) + bound(1, 1)));
    headings.push_back(std::sqrt(bound(2, 2)));
  }
  return {std::nullopt, quantile(translations, 0.5), quantile(headings, 0.5)};
}

/// The error squared in units of the bound, a share for each coordinate that there is a bound of.
double share_of_bound(const Eigen::Matrix3d& information, const Eigen::Vector3d& error_in_base) {
  const auto rank = static_cast<double>(Eigen::FullPivLU<Eigen::Matrix3d>(information).rank());
  return error_in_base.dot(information * error_in_base) / std::max(1.0, rank);
}

/// An error for each pair that was matched with success, along the axes of its base.
using SuccessErrors = std::vector<std::optional<Eigen::Vector3d>>;

std::optional<BoundStatistics> compare_with_bound(const std::vector<Eigen::Matrix3d>& information,
                                                  const SuccessErrors& errors) {
  if (information.empty()) {
    return std::nullopt;
  }
  std::vector<double> shares;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i]) {
      shares.push_back(share_of_bound(information[i], *errors[i]));
    }
  }
  BoundStatistics bound = median_bound(information);
  if (!shares.empty()) {
    bound.ratio = std::sqrt(mean(shares));
  }
  return bound;
}

bool is_success(const Eigen::Vector3d& error, const SuccessLimits& limits) {
  return error.head<2>().norm() <= limits.xy && std::abs(error.z()) <= limits.theta;
}

SearchStatistics summarize_searches(const std::vector<ScanPair>& pairs,
                                    const std::vector<PairMatch>& matches,
                                    const SuccessLimits& limits) {
  SearchStatistics statistics;
  std::vector<double> translations;
  std::vector<double> headings;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const MatchResult& result = matches[i].result;
    const Eigen::Vector3d error =
        difference(result.searched_map_from_base(), pairs[i].reference_from_base);
    translations.push_back(error.head<2>().norm());
    headings.push_back(std::abs(error.z()));
    statistics.successes += result.accepted() && is_success(error, limits) ? 1 : 0;
  }
  statistics.translation = summarize_errors(translations);
  statistics.heading = summarize_errors(headings);
  return statistics;
}

bool fits(const std::vector<Eigen::Matrix3d>& information, std::size_t pairs) {
  return information.empty() || information.size() == pairs;
}

}  // namespace

PairStatistics summarize_pairs(const std::vector<ScanPair>& pairs,
                               const std::vector<PairMatch>& matches,
                               const PairInformation& information, const SuccessLimits& limits) {
  if (pairs.empty() || matches.size() != pairs.size() ||
      !fits(information.known_world, pairs.size()) ||
      !fits(information.unknown_walls, pairs.size())) {
    throw std::invalid_argument("there must be as many matches as pairs, at least one");
  }
  PairStatistics statistics;
  statistics.pairs = pairs.size();
  std::vector<double> translations;
  std::vector<double> headings;
  std::vector<double> seconds;
  std::vector<double> nees;
  SuccessErrors success_errors(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pose2& truth = pairs[i].reference_from_base;
    const MatchResult& result = matches[i].result;
    const Eigen::Vector3d error = difference(result.map_from_base, truth);
    translations.push_back(error.head<2>().norm());
    headings.push_back(std::abs(error.z()));
    seconds.push_back(matches[i].seconds);
    if (!result.accepted()) {
      continue;
    }
    ++statistics.accepted;
    if (const auto square = squared_in_units_of(result.covariance, error)) {
      nees.push_back(*square);
    }
    if (is_success(error, limits)) {
      ++statistics.successes;
      success_errors[i] = turned_to_base(error, truth);
    }
  }
  statistics.translation = summarize_errors(translations);
  statistics.heading = summarize_errors(headings);
  statistics.seconds = summarize_errors(seconds);
  statistics.search = summarize_searches(pairs, matches, limits);
  if (!nees.empty()) {
    statistics.covariance = CovarianceStatistics{nees.size(), mean(nees), quantile(nees, 0.5)};
  }
  statistics.known_world_bound = compare_with_bound(information.known_world, success_errors);
  statistics.unknown_walls_bound = compare_with_bound(information.unknown_walls, success_errors);
  return statistics;
}

}  // namespace matchbox_slam
