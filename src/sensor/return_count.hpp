#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "matchbox_slam/sensor/laser_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// Counts the returns of scans: readings that the laser and the options take for a distance.
class ReturnCount {
 public:
  void add(const LaserScan& scan, const ProjectionOptions& options);

  /// Of one scan, the median of all; none: there were too few scans to tell.
  [[nodiscard]] std::optional<std::size_t> median() const;

 private:
  std::map<std::size_t, std::size_t> scans_;  ///< by their returns
  std::size_t total_ = 0;
};

}  // namespace matchbox_slam
