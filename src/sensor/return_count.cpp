#include "sensor/return_count.hpp"

#include <algorithm>

namespace matchbox_slam {
namespace {

constexpr std::size_t kMinCountedScans = 50;  // scans

}  // namespace

void ReturnCount::add(const LaserScan& scan, const ProjectionOptions& options) {
  const double least = std::max(scan.range_min, options.min_range);
  const double most = std::min(scan.range_max, options.max_range);
  std::size_t returns = 0;
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const auto range = static_cast<double>(scan.ranges[k]);
    const double angle = scan.angle_min + static_cast<double>(k) * scan.angle_increment;
    returns +=
        range >= least && range <= most && !is_masked(angle, options.masked_angles) ? 1U : 0U;
  }
  ++scans_[returns];
  ++total_;
}

std::optional<std::size_t> ReturnCount::median() const {
  if (total_ < kMinCountedScans) {
    return std::nullopt;
  }
  std::size_t fewer = 0;
  for (const auto& [returns, scans] : scans_) {
    fewer += scans;
    if (2 * fewer >= total_) {
      return returns;
    }
  }
  return std::nullopt;
}

}  // namespace matchbox_slam
