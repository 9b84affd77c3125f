#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// The hits of a scan as rows of numbers, and which of them may be on one wall.
struct HitRows {
  HitRows() = default;
  HitRows(const std::vector<ScanPoint>& points, double max_wall_gap) {
    assign(points, max_wall_gap);
  }

  /// Those of another scan, in the memory that there is.
  void assign(const std::vector<ScanPoint>& points, double max_wall_gap);

  /// Hits first...last, both included.
  struct Run {
    std::size_t first = 0;
    std::size_t last = 0;

    [[nodiscard]] std::size_t size() const { return last + 1 - first; }
  };

  std::size_t size = 0;
  std::vector<double> x, y;            ///< where the beams ended [m]; like the next two padded
  std::vector<double> beam_x, beam_y;  ///< unit vectors from the laser
  std::vector<double> gaps;            ///< from each hit to the next [m]
  std::vector<Run> runs;               ///< of hits that follow each other without a gap
};

/// Sums over the first hits of a run; see straighten_walls.
struct InverseRangeSum {
  double w = 0.0;
  double x = 0.0;
  double y = 0.0;
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;

  [[nodiscard]] double determinant() const { return xx * yy - xy * xy; }
};

/// What the functions below work in, kept from scan to scan; what it holds never matters.
struct WallMemory {
  std::vector<double> squares_of_all, squares;
  std::vector<InverseRangeSum> sums;
  std::vector<HitRows::Run> open, pieces;
};

/// Standard deviation of the ranges of neighbouring hits about a smooth surface [m]: how far each
/// hit lies, along its beam, from the line through its two neighbours. Hits that lie much farther
/// off than the others, as at corners and edges, do not count. 0 when there are too few.
[[nodiscard]] double range_noise(const HitRows& hits, WallMemory& memory);
[[nodiscard]] inline double range_noise(const HitRows& hits) {
  WallMemory memory;
  return range_noise(hits, memory);
}

/// Cuts the scan into straight walls, as far as a straight wall explains the hits within their
/// noise, and moves each hit along its beam onto its wall, whose normal it gets. Hits that are part
/// of no such wall, and those too far off it, stay where they are, with a normal of zero. The walls
/// are lines of least squares of the ranges: a grazing beam tells a wall's place much better than
/// one that meets it head on. Where a full circle begins and ends, a wall is taken for two. Cost:
/// linear in the number of points.
/// @param hits  of these points.
void straighten_walls(const HitRows& hits, double noise, WallMemory& memory,
                      std::vector<ScanPoint>& points);
inline void straighten_walls(const HitRows& hits, double noise, std::vector<ScanPoint>& points) {
  WallMemory memory;
  straighten_walls(hits, noise, memory, points);
}

}  // namespace matchbox_slam
