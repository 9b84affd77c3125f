#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// How the Hough domain is cut into cells.
struct HoughGrid {
  int angles = 180;        ///< columns over the half circle
  double rho_cell = 0.03;  ///< [m]

  /// Direction of a column's normal [rad], in [0, pi) for columns from 0.
  [[nodiscard]] double angle(double column) const;
};

/// A scan as votes: points on walls, each with the length of wall that it stands for.
struct HoughPoints {
  std::vector<float> x, y, weight;  ///< [m]
  double reach = 0.0;               ///< distance of the farthest point from the origin [m]

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] bool empty() const { return x.empty(); }
};

/// The points of a scan that vote. Each stands for half the way to its neighbours, so that near
/// walls with many returns do not outvote far ones; a jump from one surface to another is no wall,
/// and points with a jump on both sides are left out. Neighbours closer than `spacing` [m] become
/// one point. What is no number, or farther than any planar laser sees, is left out.
[[nodiscard]] HoughPoints hough_points(const std::vector<ScanPoint>& points, double spacing);

/// One column of the Hough transform: HT(theta, rho) = sum of the weights of the points with x cos
/// theta + y sin theta = rho, each split between the two cells whose middles it lies between.
/// @param half_cells  > reach / rho_cell + 1.
/// @return cells from -half_cells to half_cells; the middle of cell i is at i rho_cell.
/// Cost: the points and the cells.
[[nodiscard]] std::vector<float> hough_column(const HoughPoints& points, double theta,
                                              double rho_cell, int half_cells);

/// Cells to each side of 0 that hold every point's votes.
[[nodiscard]] int hough_half_cells(const HoughPoints& points, double rho_cell);

/// What a spectrum takes of each column. Neither changes when the scan is moved without turning.
enum class SpectrumKind {
  /// the sum of squares over rho: equation 3 of "The Scan Matchers Research and Comparison:
  /// Monte-Carlo, Olson and Hough"
  kEnergy,
  kMaximum,  ///< the strongest cell
};

/// The Hough spectrum over the half circle; the other half is the same, since HT(theta + pi, rho) =
/// HT(theta, -rho) (Censi, Iocchi and Grisetti 2005, section III). Turning the scan by phi shifts
/// it by phi. Cost: columns times points and cells.
[[nodiscard]] std::vector<float> hough_spectrum(const HoughPoints& points, const HoughGrid& grid,
                                                SpectrumKind kind);

/// The circular cross-correlation of two spectra without their means, -1...1: entry k is for the
/// scan turned by k columns to meet the reference. Cost: columns squared.
[[nodiscard]] std::vector<float> correlate_spectra(const std::vector<float>& reference,
                                                   const std::vector<float>& scan);

}  // namespace matchbox_slam
