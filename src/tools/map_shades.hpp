#pragma once

#include <cstdint>
#include <vector>

#include "io/picture.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {

/// How dark a cell is drawn in a movie: not seen, or by steps from free to occupied.
using Shade = std::uint8_t;
constexpr Shade kUnseenShade = 0;
constexpr Shade kDarkestShade = 8;

[[nodiscard]] Shade shade_of(const OccupancyGrid& map, const Cell& cell);
[[nodiscard]] Color color_of_shade(Shade shade);

/// What an occupancy grid looks like, packed: 4 bytes for cells side by side that look the same.
class MapShades {
 public:
  MapShades() = default;
  explicit MapShades(const OccupancyGrid& map);

  /// That were seen.
  [[nodiscard]] const CellBox& cells() const { return cells_; }

  /// Calls take(y, from, to, shade) for cells side by side, which were seen.
  template <typename Take>
  void for_each_run(Take&& take) const {
    Cell at = cells_.min;
    for (const Run& run : runs_) {
      if (run.shade != kUnseenShade) {
        take(at.y, at.x, at.x + run.length, run.shade);
      }
      at.x += run.length;
      if (at.x == cells_.max.x) {
        at = {cells_.min.x, at.y + 1};
      }
    }
  }

 private:
  struct Run {
    std::uint16_t length;
    Shade shade;
  };
  void add_row(const OccupancyGrid& map, int y);

  CellBox cells_;
  std::vector<Run> runs_;  ///< row by row, the lowest first; each row begins anew
};

}  // namespace matchbox_slam
