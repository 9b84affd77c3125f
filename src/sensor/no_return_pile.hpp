#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// Finds lasers whose beams read a range of their own, plus noise, where they meet nothing, so that
/// they seem to hit a wall there: range_max, or, as many logs have it, the largest range that the
/// laser ever reads while range_max is more. The sign is a pile of readings about the largest one,
/// in most directions, with hardly any reading just below: walls are at all ranges. A pile below
/// range_max has to stay where it is while what else is seen changes, as walls do not when the
/// robot moves.
class NoReturnPile {
 public:
  /// Scans of one laser; those of another range_max than the first are left out.
  void add(const LaserScan& scan);

  /// The range [m] from which on a reading is no return; none: there is no such pile, or too few
  /// scans have come to tell.
  [[nodiscard]] std::optional<double> first_range() const;

 private:
  struct Reading {
    float range;
    std::uint32_t beam;
    std::uint32_t scan;
  };

  [[nodiscard]] std::optional<double> first_of(const std::vector<Reading>& pile) const;
  [[nodiscard]] std::size_t without_stuck_beam(const std::vector<Reading>& readings) const;
  [[nodiscard]] bool has_moved(const std::vector<Reading>& pile) const;
  [[nodiscard]] bool is_all_around(const std::vector<Reading>& pile) const;
  void drop_short_ones();

  double range_max_ = 0.0;           ///< [m]
  std::size_t beams_ = 0;            ///< of a scan
  float largest_ = 0.0F;             ///< reading [m]
  std::vector<Reading> readings_;    ///< not much shorter than the largest one
  std::vector<float> median_range_;  ///< of each scan's readings that are shorter [m]
};

}  // namespace matchbox_slam
