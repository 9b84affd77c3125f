#pragma once

#include <cstddef>
#include <vector>

namespace matchbox_slam {

/// What the literature reports of a set of errors, in the unit of the errors.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// The value below which a `fraction` in [0, 1] of the values lies, interpolated linearly between
/// the two nearest ranks (as numpy.percentile does). Throws std::invalid_argument when there are no
/// values.
[[nodiscard]] double quantile(std::vector<double> values, double fraction);

/// @param errors  >= 0; in any order. Throws std::invalid_argument when there are none.
[[nodiscard]] ErrorStatistics summarize_errors(const std::vector<double>& errors);

/// Statistics of durations; all 0 when there are none.
[[nodiscard]] ErrorStatistics statistics_of(const std::vector<float>& values);

}  // namespace matchbox_slam
