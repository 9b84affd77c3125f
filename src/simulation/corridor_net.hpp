#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {

/// Corridors that meet at crossings.
class CorridorNet {
 public:
  struct Corridor {
    std::size_t from;  ///< numbers of crossings
    std::size_t to;
    double length;  ///< [m]
  };

  /// Adds a straight corridor, and crossings where there are none yet.
  void add(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

  [[nodiscard]] const std::vector<Eigen::Vector2d>& crossings() const { return crossings_; }
  [[nodiscard]] const std::vector<Corridor>& corridors() const { return corridors_; }

  /// The crossings of a drive from the first one: at each on along a corridor that was driven least
  /// often, not back where that can be helped; once it is longer than `length` [m], home the
  /// shortest way.
  [[nodiscard]] std::vector<std::size_t> tour(double length, Random& random) const;

 private:
  [[nodiscard]] std::size_t crossing_at(const Eigen::Vector2d& place);
  [[nodiscard]] std::vector<double> ways_home() const;

  std::vector<Eigen::Vector2d> crossings_;
  std::vector<Corridor> corridors_;
};

}  // namespace matchbox_slam
