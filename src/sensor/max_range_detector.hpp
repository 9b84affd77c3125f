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
/// robot moves, and scans have to show it in several directions with something else between.
/// It is looked for after each 20 scans, among those of the first ten seconds, or the first
/// hundred, whichever is more, and of two minutes at most. By the stamps and number of the scans
/// alone, so that the same scans always tell the same.
class MaxRangeDetector {
 public:
  /// Scans of one laser; those of another range_max than the first are left out, and all that come
  /// once it is complete.
  void add(const LaserScan& scan);

  /// Whether it is found, or is not looked for any more.
  [[nodiscard]] bool is_complete() const { return is_complete_; }

  /// The range [m] from which on a reading is no return; none: there is no such pile, or too few
  /// scans have come to tell.
  [[nodiscard]] std::optional<double> first_range() const { return first_range_; }

 private:
  struct Reading {
    float range;
    std::uint32_t beam;
    std::uint32_t scan;
  };

  void add_readings(const LaserScan& scan);
  [[nodiscard]] std::optional<double> find_first_range() const;
  [[nodiscard]] std::optional<double> first_of(const std::vector<Reading>& pile) const;
  [[nodiscard]] std::size_t without_stuck_beam(const std::vector<Reading>& readings) const;
  [[nodiscard]] bool has_moved(const std::vector<Reading>& pile) const;
  [[nodiscard]] bool is_scattered(const std::vector<Reading>& pile) const;
  void drop_short_ones();

  bool is_complete_ = false;
  std::optional<double> first_range_;
  double range_max_ = 0.0;           ///< [m]
  double begin_ = 0.0;               ///< [s], stamp of the first scan
  std::size_t beams_ = 0;            ///< of a scan
  float largest_ = 0.0F;             ///< reading [m]
  std::vector<Reading> readings_;    ///< not much shorter than the largest one
  std::vector<float> median_range_;  ///< of each scan's readings that are shorter [m]
};

}  // namespace matchbox_slam
