#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/map/grid_geometry.hpp"
#include "matchbox_slam/map/map_image.hpp"

namespace matchbox_slam {

/// A region between walls that nothing can leave.
using EnclosedArea = std::vector<Cell>;

/// How clean a map is, told from the map alone (Filatov, Filatov, Krinkin, Chen and Molodan, "2D
/// SLAM quality evaluation methods", 2017). A wall that is drawn twice, or smeared, has more
/// occupied cells, more corners and more areas that it closes; so of two maps of the same place the
/// one with the lower figures is better. Figures of different places or resolutions say nothing.
struct MapQuality {
  std::size_t occupied_cells = 0;
  std::size_t free_cells = 0;
  std::vector<Eigen::Vector2d> corners;      ///< [cells] from the map's lower left corner
  std::vector<EnclosedArea> enclosed_areas;  ///< cells are counted from the lower left one

  [[nodiscard]] std::size_t known_cells() const { return occupied_cells + free_cells; }

  /// Occupied cells over all known ones, 0...1.
  [[nodiscard]] double occupied_of_known() const {
    return static_cast<double>(occupied_cells) / static_cast<double>(known_cells());
  }

  /// Occupied cells over free ones: the proportion of Filatov et al.
  [[nodiscard]] double occupied_of_free() const {
    return static_cast<double>(occupied_cells) / static_cast<double>(free_cells);
  }
};

/// Measures a map. Cells are what map_server makes of them. What is unknown does not count, however
/// wide its margin; a map turned by a right angle has the same figures.
///
/// For corners and areas, patches of less than 5 occupied cells are left out and gaps of up to two
/// cells closed. Corners are Harris's (Harris and Stephens 1988) on these walls, blurred and passed
/// through a Laplacian. Their threshold is a share of what an ideal right angle yields; the
/// customary share of the image's own highest value lets a single spot decide about all others. Of
/// corners within 10 cells of each other along both axes the most distinct one counts. Enclosed
/// areas are the regions of at least 3 x 3 cells that walls separate, also diagonally, from what is
/// around the map.
///
/// Cost: the map's pixels.
/// Throws EvaluationError when no cell is free, which leaves the proportion undefined.
[[nodiscard]] MapQuality measure_map_quality(const MapImage& map);

}  // namespace matchbox_slam
