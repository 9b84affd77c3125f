#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

// The surfaces that a scan's points lie on, by their neighbours from beam to beam, and how much
// wall each stands for.

/// Sums over the first points of a scan, so that a line through any run of them is fitted in
/// constant time.
class RunningSums {
 public:
  void assign(const std::vector<ScanPoint>& points) {
    sums_.clear();
    sums_.reserve(points.size() + 1);
    sums_.emplace_back();
    for (const ScanPoint& point : points) {
      const double x = point.position.x();
      const double y = point.position.y();
      const Sums& last = sums_.back();
      sums_.push_back({last.x + x, last.y + y, last.xx + x * x, last.xy + x * y, last.yy + y * y});
    }
  }

  /// Second moments of a run of points about their mean [m^2].
  struct Spread {
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    double smallest = 0.0;  ///< eigenvalue: squared rms distance from the best line
    double largest = 0.0;   ///< eigenvalue: squared rms extent along it

    /// Unit normal of the line of total least squares.
    [[nodiscard]] Eigen::Vector2d normal() const {
      const Eigen::Vector2d a(xy, smallest - xx);
      const Eigen::Vector2d b(smallest - yy, xy);
      return (a.squaredNorm() > b.squaredNorm() ? a : b).normalized();
    }
  };

  /// Of the points first...last, both included.
  [[nodiscard]] Spread spread(std::size_t first, std::size_t last) const {
    const Sums& a = sums_[first];
    const Sums& b = sums_[last + 1];
    const double share = 1.0 / static_cast<double>(last + 1 - first);
    const double mean_x = (b.x - a.x) * share;
    const double mean_y = (b.y - a.y) * share;
    const double xx = (b.xx - a.xx) * share - mean_x * mean_x;
    const double xy = (b.xy - a.xy) * share - mean_x * mean_y;
    const double yy = (b.yy - a.yy) * share - mean_y * mean_y;
    const double half_difference = 0.5 * (xx - yy);
    const double half_spread = std::sqrt(half_difference * half_difference + xy * xy);
    const double middle = 0.5 * (xx + yy);
    return {xx, xy, yy, std::max(0.0, middle - half_spread), middle + half_spread};
  }

 private:
  struct Sums {
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
  };
  std::vector<Sums> sums_;
};

/// Distance from each point to the one after it; one element less than points.
void find_gaps(const std::vector<ScanPoint>& points, std::vector<double>& gaps);

/// Finds the normals of the points that have none, towards the laser, and which points are joined
/// to the next one by a wall.
/// @param gaps  of find_gaps.
/// @param sums  on the way.
void add_surfaces(const std::vector<double>& gaps, const ProjectionOptions& options,
                  RunningSums& sums, std::vector<ScanPoint>& points);

/// Gives normals to points that have none and are two of a wall that the beams meet head on: far
/// away the crack of a corner or a door shows so little of one that no line can be fitted, but that
/// both beams are about as long says which way it faces. A corridor has hardly more that tells the
/// way along it. Points on the line of a wall that is seen beside them are none: there the beams
/// are far apart as they graze it.
void add_facing_pairs(std::vector<ScanPoint>& points);

/// Finds how far apart the beams are at the points.
void add_spacings(std::vector<ScanPoint>& points);

/// Each point stands for half the way to its neighbours on both sides, as far as the surface is
/// known there. After `add_spacings`.
/// @param gaps  of find_gaps.
/// @param cap   [m] that it stands for at most.
void add_weights(const std::vector<double>& gaps, double cap, std::vector<ScanPoint>& points);

}  // namespace matchbox_slam
