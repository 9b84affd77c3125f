#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/map/grid_geometry.hpp"
#include "matchbox_slam/map/tiled_grid.hpp"

namespace matchbox_slam {

struct LikelihoodFieldOptions {
  double sigma = 0.045;
  double reach = 0.4;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.sigma, "sigma", between(1e-3, 1.0), "m",
           "Standard deviation of the likelihood of a scan point by its distance to a surface.");
    option(
        self.reach, "reach", between(0.05, 5.0), "m",
        "The distance to the nearest surface is kept up to here; beyond, a cell is far from all.");
  }
};

/// A piece of wall within one cell, averaged over the hits that fell there.
struct Surface {
  Eigen::Vector2d position;  ///< [m], map frame
  /// (cos 2a, sin 2a) of the direction a of the wall's normal, so that a normal and its opposite
  /// are the same. Its length is 1 when the hits agree on a line and 0 when they tell no direction.
  Eigen::Vector2d double_angle;
  /// Mean of the normals themselves: towards where the wall was seen from, 1 long where all saw the
  /// same side, and 0 where its two sides fall into one cell.
  Eigen::Vector2d facing;
  int hits;  ///< that the average was taken over, at most 64
};

/// Whether a hit with this normal, in the same frame, shows the other side of a wall, which lies
/// the wall's thickness behind. A hit without normal shows no side.
[[nodiscard]] inline bool is_other_side(const Surface& surface, const Eigen::Vector2d& normal) {
  constexpr double kMaxOppositeCosine = -0.5;
  return surface.facing.dot(normal) < kMaxOppositeCosine;
}

/// A hit in the map frame, to be taken into the field.
struct SurfaceHit {
  Eigen::Vector2d position;
  Eigen::Vector2d normal;  ///< zero when unknown
};

/// The lookup table of correlative matching (Olson 2009, section III): for every cell near a
/// surface how likely a scan point falls there, the distance to the nearest surface, and which cell
/// that surface lies in. Distances are to the mean position of the hits, not to cell centres, and
/// combine by nearest-wins, so that dense surfaces are not more likely than sparse ones.
///
/// Kept up to date: an update renders anew only the blocks around surfaces that changed, and yields
/// the same bits as rendering everything from scratch, also after surfaces were removed.
class LikelihoodField {
 public:
  struct Tile {
    static constexpr std::size_t kCells = std::size_t{64} * 64;
    std::array<std::uint8_t, kCells> likelihood;  ///< 255 exp(-d^2 / 2 sigma^2), rounded
    std::array<std::uint8_t, kCells> distance;    ///< 255 d / reach, rounded; 255: reach or farther
    std::array<std::int8_t, kCells> nearest_x;    ///< nearest surface's cell minus this cell
    std::array<std::int8_t, kCells> nearest_y;
  };
  using Tiles = TiledGrid<Tile, 6>;

  static constexpr std::uint8_t kFar = 255;  ///< `distance` of cells without a surface in reach

  /// Of a cell: a wall so near to its centre goes through it, unless it cuts off a corner; half a
  /// diagonal is 0.71. With half of it beams slip through, and carried robots do not get lost
  /// (CONSTANTS.md: 2.07 m instead of 0.04); with double aces is 14 % worse.
  static constexpr double kMaxCellsToWall = 0.6;

  /// @param resolution  edge of a cell [m], > 0. `reach / resolution` must not exceed 120 cells.
  /// Throws ConfigurationError otherwise.
  LikelihoodField(double resolution, const LikelihoodFieldOptions& options);

  /// Takes in new hits and drops the surfaces of cells that turned out free, then renders.
  void update(const std::vector<SurfaceHit>& hits, const std::vector<Cell>& cleared);

  /// The same without rendering, for many updates of which only the last is looked at: its
  /// likelihoods after `render`, which way surfaces face after `settle`, too.
  void take(const std::vector<SurfaceHit>& hits, const std::vector<Cell>& cleared);

  /// Decides which way the surfaces face that have changed since it was rendered.
  void settle();
  /// The same, and renders the likelihoods around them.
  void render();
  /// Whether nothing has changed since.
  [[nodiscard]] bool is_rendered() const { return changed_.empty(); }

  [[nodiscard]] const GridGeometry& geometry() const { return geometry_; }
  [[nodiscard]] const LikelihoodFieldOptions& options() const { return options_; }
  [[nodiscard]] bool empty() const { return surface_count_ == 0; }

  [[nodiscard]] const Tiles& tiles() const { return tiles_; }

  /// Likelihood of a scan point in this cell, 0...255; 0 far from everything.
  [[nodiscard]] std::uint8_t likelihood(const Cell& cell) const {
    const Tile* tile = tiles_.find(Tiles::tile_of(cell));
    return tile == nullptr ? std::uint8_t{0} : tile->likelihood[Tiles::index_in_tile(cell)];
  }

  /// Distance from the cell's centre to the nearest surface, 255 being `reach` or more.
  [[nodiscard]] std::uint8_t distance(const Cell& cell) const {
    const Tile* tile = tiles_.find(Tiles::tile_of(cell));
    return tile == nullptr ? kFar : tile->distance[Tiles::index_in_tile(cell)];
  }

  /// [m] that 1 in `distance` stands for.
  [[nodiscard]] double metres_per_step() const { return options_.reach / kFar; }

  /// The surface nearest to the cell's centre. False when there is none within reach.
  [[nodiscard]] bool nearest_surface(const Cell& cell, Surface& surface) const;

  /// Whether a hit in this cell, with this normal in the field's frame, shows the other side of the
  /// wall there; see is_other_side.
  [[nodiscard]] bool shows_other_side(const Cell& cell, const Eigen::Vector2d& normal) const {
    Surface surface;
    return nearest_surface(cell, surface) && is_other_side(surface, normal);
  }

  /// Cells that hold a surface, by rows of tiles; for pictures and tests.
  [[nodiscard]] std::vector<Cell> surface_cells() const;

  [[nodiscard]] bool has_surface(const Cell& cell) const;

  /// A surface as it is kept: fractions of 32767.
  struct StoredSurface {
    std::uint16_t hits = 0;
    std::int16_t offset_x = 0;  ///< mean position within the cell, from centre to edge
    std::int16_t offset_y = 0;
    std::int16_t mean_double_angle_x = 0;  ///< over the hits
    std::int16_t mean_double_angle_y = 0;
    std::int16_t double_angle_x = 0;  ///< as in Surface
    std::int16_t double_angle_y = 0;
    std::int8_t facing_x = 0;  ///< as in Surface, in parts of 127
    std::int8_t facing_y = 0;
  };

  /// The surface of a cell that has one; unchecked.
  [[nodiscard]] const StoredSurface& stored_surface(const Cell& cell) const {
    return *find_surface(cell);
  }

  /// Makes these the field's surfaces, instead of any that were there, and renders them all: with
  /// every cell of `surface_cells` and its `stored_surface` the copy is the original, bit by bit.
  void restore(const std::vector<std::pair<Cell, StoredSurface>>& surfaces);

  [[nodiscard]] std::size_t bytes() const { return tiles_.bytes() + surfaces_.bytes(); }

 private:
  struct SurfaceTile {
    std::uint64_t present = 0;  ///< a bit for every cell with hits
    std::uint64_t changed = 0;  ///< one for every cell that changed since it was rendered
    std::array<StoredSurface, std::size_t{8} * 8> surfaces;
  };
  using SurfaceTiles = TiledGrid<SurfaceTile, 3>;

  void make_room_for(const std::vector<SurfaceHit>& hits);
  void add_hit(const SurfaceHit& hit);
  void remove_surface(const Cell& cell);
  [[nodiscard]] const StoredSurface* find_surface(const Cell& cell) const;
  SurfaceTile& touch_tile(const Cell& cell);  ///< that of a cell, for writing
  /// The surface of a cell for writing; it counts as there, and as changed, from now on.
  StoredSurface& touch_surface(const Cell& cell);
  void note_change(const Cell& cell, SurfaceTile& tile);
  void settle(const Cell& cell);
  void render_changed();
  void render_around(const std::vector<Cell>& changed);
  [[nodiscard]] std::vector<Cell> blocks_around(const std::vector<Cell>& changed) const;
  /// Calls `visit(cell, stored_surface)` tile by tile, each by rows.
  template <typename Visitor>
  void visit_surfaces(const CellBox& box, Visitor&& visit) const;

  GridGeometry geometry_;
  LikelihoodFieldOptions options_;
  int reach_cells_;
  /// Likelihood and distance (times 256) by squared distance, in equal steps from 0 to reach
  /// squared; the last entry is for what is farther.
  std::vector<std::uint16_t> of_square_;
  std::size_t surface_count_ = 0;
  std::vector<Cell> changed_;  ///< since it was rendered, each once
  SurfaceTiles surfaces_;
  Tiles tiles_;
};

}  // namespace matchbox_slam
