#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// Finds lasers whose beams read range_max plus noise where they meet nothing, so that every other
/// of them seems to hit a wall there. The sign is a pile of readings about range_max in most scans,
/// in most directions, with hardly any reading just below: walls are at all ranges, and come nearer
/// as the robot moves.
class NoReturnPile {
 public:
  /// Scans of one laser; those of another range_max than the first are left out.
  void add(const LaserScan& scan);

  /// The range [m] from which on a reading is no return; none: there is no such pile, or too few
  /// scans have come to tell.
  [[nodiscard]] std::optional<double> first_range() const;

 private:
  // Guesses: half and double were not tried.
  static constexpr std::size_t kSectors = 12;
  static constexpr std::size_t kFewestSectors = 8;

  double range_max_ = 0.0;  ///< [m]
  std::size_t scans_ = 0;
  std::size_t scans_with_pile_ = 0;
  std::size_t below_ = 0;                          ///< readings short of the pile
  std::vector<double> pile_;                       ///< [m]
  std::array<std::size_t, kSectors> in_sector_{};  ///< readings of the pile below range_max
};

}  // namespace matchbox_slam
