#include "evaluation/error_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace matchbox_slam {
namespace {

double quantile_of_sorted(const std::vector<double>& sorted, double fraction) {
  if (sorted.empty()) {
    throw std::invalid_argument("no values, so no quantile of them");
  }
  const double rank = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  if (sorted[below] == sorted[above]) {
    return sorted[below];  // also when both are infinite, which have no difference
  }
  return sorted[below] + (rank - std::floor(rank)) * (sorted[above] - sorted[below]);
}

}  // namespace

double quantile(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return quantile_of_sorted(values, fraction);
}

ErrorStatistics summarize_errors(const std::vector<double>& errors) {
  if (errors.empty()) {
    throw std::invalid_argument("no errors to summarize");
  }
  std::vector<double> sorted = errors;
  std::sort(sorted.begin(), sorted.end());
  const auto count = static_cast<double>(sorted.size());
  ErrorStatistics statistics;
  statistics.count = sorted.size();
  statistics.rmse =
      std::sqrt(std::inner_product(sorted.begin(), sorted.end(), sorted.begin(), 0.0) / count);
  statistics.mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / count;
  statistics.median = quantile_of_sorted(sorted, 0.5);
  statistics.p95 = quantile_of_sorted(sorted, 0.95);
  statistics.p99 = quantile_of_sorted(sorted, 0.99);
  statistics.max = sorted.back();
  return statistics;
}

ErrorStatistics statistics_of(const std::vector<float>& values) {
  return values.empty() ? ErrorStatistics{} : summarize_errors({values.begin(), values.end()});
}

}  // namespace matchbox_slam
