#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/grid_geometry.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/map/tiled_grid.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// How often beams ended in each cell, and how often they went on through it: the counting model of
/// reflection maps (Hähnel, Burgard, Thrun 2003, section 3). A wall is hit by all beams, a railing
/// by half of them, and stays half a wall however often it is seen. Cells that nothing was seen of
/// have neither.
///
/// A scan counts once in each cell, whatever share of its beams ended there; and what was counted
/// long ago makes room for what is seen now.
class ReflectionGrid {
 public:
  /// In quarters of a scan, so that a scan may count for both.
  struct Counts {
    std::uint8_t hits = 0;
    std::uint8_t passes = 0;

    [[nodiscard]] bool is_known() const { return (hits | passes) != 0; }
  };
  static constexpr int kScan = 4;           ///< what one scan counts
  static constexpr int kMaxCount = 4 * 24;  ///< of hits and passes together

  using Tile = std::array<Counts, std::size_t{64} * 64>;
  using Tiles = TiledGrid<Tile, 6>;

  /// @param resolution  edge of a cell [m], > 0.
  explicit ReflectionGrid(double resolution);
  ReflectionGrid(const ReflectionGrid& other);
  ReflectionGrid(ReflectionGrid&& other) noexcept;
  ReflectionGrid& operator=(const ReflectionGrid& other);
  ReflectionGrid& operator=(ReflectionGrid&& other) noexcept;
  ~ReflectionGrid();

  [[nodiscard]] const GridGeometry& geometry() const { return geometry_; }

  [[nodiscard]] Counts counts(const Cell& cell) const {
    const Tile* tile = tiles_.find(Tiles::tile_of(cell));
    return tile == nullptr ? Counts{} : (*tile)[Tiles::index_in_tile(cell)];
  }

  /// Counts a scan that was taken there. Beams pass each cell up to `clearance_of` their ends.
  /// Beams without return count nowhere: glass has them, too. Nor does a scan with points that are
  /// farther apart than any laser reaches.
  void count(const PointScan& scan, const Pose2& map_from_base);

  /// Of a map that comes without the scans that made it: as if a few of them had seen each cell.
  void count(const OccupancyGrid& occupancy);

  [[nodiscard]] bool empty() const { return tiles_.tile_bounds().empty(); }
  [[nodiscard]] const Tiles& tiles() const { return tiles_; }
  [[nodiscard]] std::size_t bytes() const { return tiles_.bytes(); }

 private:
  class Tally;

  GridGeometry geometry_;
  Tiles tiles_;
  std::unique_ptr<Tally> tally_;  ///< of a scan; kept for its memory, and not copied
};

/// How far before its end a beam says nothing of the cells that it passes [m]: there it may touch
/// the surface that it ends on, the longer the more it grazes.
[[nodiscard]] double clearance_of(const ScanPoint& point);

/// The cells of a segment in order, without its last one: Bresenham's walk in integers, which steps
/// along the longer side. Calls visit(cell).
template <typename Visit>
void walk_cells(const Cell& from, const Cell& to, Visit&& visit) {
  const int dx = to.x - from.x;
  const int dy = to.y - from.y;
  const int width = dx < 0 ? -dx : dx;
  const int height = dy < 0 ? -dy : dy;
  const int step_x = dx < 0 ? -1 : 1;
  const int step_y = dy < 0 ? -1 : 1;
  int error = width - height;
  for (Cell cell = from; !(cell == to);) {
    visit(cell);
    const int twice = 2 * error;
    const bool along_x = twice > -height;
    const bool along_y = twice < width;
    error += (along_y ? width : 0) - (along_x ? height : 0);
    cell.x += along_x ? step_x : 0;
    cell.y += along_y ? step_y : 0;
  }
}

}  // namespace matchbox_slam
