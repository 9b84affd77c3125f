#include "sensor/no_return_pile.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

// Guesses: half and double were not tried.
// [m], of the pile about range_max to either side: kDeviations of 6 cm.
constexpr double kWidth = 0.3;
constexpr std::size_t kFewestScans = 20;
constexpr double kMostScans = 0.7;
constexpr double kFewestBeams = 0.01;  // of a scan
constexpr double kContrast = 5.0;      // to what lies below, on the same width
constexpr double kDeviations = 5.0;

/// Reorders the values.
double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void NoReturnPile::add(const LaserScan& scan) {
  range_max_ = scans_ == 0 ? scan.range_max : range_max_;
  if (scan.range_max != range_max_ || scan.ranges.empty()) {
    return;
  }
  ++scans_;
  std::size_t short_of_maximum = 0;
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const double over = static_cast<double>(scan.ranges[k]) - range_max_;
    if (!(over >= -3.0 * kWidth && over < kWidth)) {
      continue;
    }
    if (over < -kWidth) {
      ++below_;
      continue;
    }
    pile_.push_back(range_max_ + over);
    if (over < 0.0) {
      ++short_of_maximum;
      ++in_sector_.at(k * kSectors / scan.ranges.size());
    }
  }
  const double fewest = std::max(3.0, kFewestBeams * static_cast<double>(scan.ranges.size()));
  scans_with_pile_ += static_cast<double>(short_of_maximum) >= fewest ? 1 : 0;
}

std::optional<double> NoReturnPile::first_range() const {
  const bool in_most_scans = scans_ >= kFewestScans && static_cast<double>(scans_with_pile_) >=
                                                           kMostScans * static_cast<double>(scans_);
  const bool stands_out =
      static_cast<double>(pile_.size()) >= kContrast * static_cast<double>(below_);
  const auto sectors = std::count_if(in_sector_.begin(), in_sector_.end(), [&](std::size_t count) {
    return 100 * count >= pile_.size();
  });
  if (!in_most_scans || !stands_out || static_cast<std::size_t>(sectors) < kFewestSectors) {
    return std::nullopt;
  }
  std::vector<double> values = pile_;
  const double middle = median_of(values);
  for (double& value : values) {
    value = std::abs(value - middle);
  }
  const double deviation = std::max(1e-3, 1.4826 * median_of(values));
  const double first = middle - kDeviations * deviation;
  return first > range_max_ - kWidth ? std::optional(first) : std::nullopt;
}

}  // namespace matchbox_slam
