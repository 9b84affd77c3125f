#include "matchbox_slam/evaluation/pair_statistics.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace matchbox_slam {
namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The error of a pose over (x, y, theta) along the axes in which both are given.
Eigen::Vector3d error_of(const Pose2& pose, const Pose2& truth) {
  return {pose.x - truth.x, pose.y - truth.y, wrap_angle(pose.theta - truth.theta)};
}

/// The same along the axes of the true pose.
Eigen::Vector3d turned_to_base(const Eigen::Vector3d& error, const Pose2& truth) {
  const Eigen::Vector2d along = Pose2{0.0, 0.0, -truth.theta} * Eigen::Vector2d(error.head<2>());
  return {along.x(), along.y(), error.z()};
}

double squared_in_units_of(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& error) {
  return error.dot(covariance.inverse() * error);
}

/// Collects the bound's share in the statistics.
class BoundSum {
 public:
  void add(const Eigen::Matrix3d& information, const Eigen::Vector3d& error_in_base) {
    squares_.push_back(error_in_base.dot(information * error_in_base) / 3.0);
    const Eigen::FullPivLU<Eigen::Matrix3d> solver(information);
    if (solver.isInvertible()) {
      const Eigen::Matrix3d bound = solver.inverse();
      translations_.push_back(std::sqrt(bound(0, 0) + bound(1, 1)));
      headings_.push_back(std::sqrt(bound(2, 2)));
    } else {
      translations_.push_back(std::numeric_limits<double>::infinity());
      headings_.push_back(std::numeric_limits<double>::infinity());
    }
  }

  [[nodiscard]] std::optional<BoundStatistics> statistics() const {
    if (squares_.empty()) {
      return std::nullopt;
    }
    return BoundStatistics{std::sqrt(mean(squares_)), quantile(translations_, 0.5),
                           quantile(headings_, 0.5)};
  }

 private:
  std::vector<double> squares_;
  std::vector<double> translations_;
  std::vector<double> headings_;
};

}  // namespace

PairStatistics summarize_pairs(const std::vector<ScanPair>& pairs,
                               const std::vector<PairMatch>& matches,
                               const std::vector<Eigen::Matrix3d>& information,
                               const SuccessLimits& limits) {
  if (pairs.empty() || matches.size() != pairs.size() ||
      (!information.empty() && information.size() != pairs.size())) {
    throw std::invalid_argument("there must be as many matches as pairs, at least one");
  }
  PairStatistics statistics;
  statistics.pairs = pairs.size();
  std::vector<double> translations;
  std::vector<double> headings;
  std::vector<double> seconds;
  std::vector<double> nees;
  BoundSum bound;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pose2& truth = pairs[i].reference_from_base;
    const MatchResult& result = matches[i].result;
    const Eigen::Vector3d error = error_of(result.map_from_base, truth);
    translations.push_back(error.head<2>().norm());
    headings.push_back(std::abs(error.z()));
    seconds.push_back(matches[i].seconds);
    if (!result.accepted()) {
      continue;
    }
    ++statistics.accepted;
    nees.push_back(squared_in_units_of(result.covariance, error));
    if (translations.back() <= limits.xy && headings.back() <= limits.theta) {
      ++statistics.successes;
      if (!information.empty()) {
        bound.add(information[i], turned_to_base(error, truth));
      }
    }
  }
  statistics.translation = summarize_errors(translations);
  statistics.heading = summarize_errors(headings);
  statistics.seconds = summarize_errors(seconds);
  if (!nees.empty()) {
    statistics.covariance = CovarianceStatistics{mean(nees), quantile(nees, 0.5)};
  }
  statistics.bound = bound.statistics();
  return statistics;
}

}  // namespace matchbox_slam
