#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/map/grid_geometry.hpp"
#include "matchbox_slam/map/tiled_grid.hpp"

namespace matchbox_slam {

/// How likely each cell is occupied, in an unbounded grid that grows by tiles.
/// The cell model is tinySLAM's (Steux and El Hamzaoui 2010): a cell starts in the middle and each
/// observation is blended in with a quality, so that it never saturates and follows changes.
class OccupancyGrid {
 public:
  /// Stored form of a probability: 0 says that the cell was never observed, 1...65535 is 0...1.
  using Stored = std::uint16_t;
  static constexpr Stored kUnknown = 0;
  static constexpr double kSteps = 65534.0;  ///< from probability 0 to 1

  using Tile = std::array<Stored, std::size_t{64} * 64>;
  using Tiles = TiledGrid<Tile, 6>;

  /// @param resolution  edge of a cell [m], > 0.
  explicit OccupancyGrid(double resolution) : geometry_(resolution) {}

  [[nodiscard]] const GridGeometry& geometry() const { return geometry_; }

  [[nodiscard]] bool is_known(const Cell& cell) const { return stored(cell) != kUnknown; }

  /// Probability that the cell is occupied, in [0, 1]; 0.5 where nothing was observed.
  [[nodiscard]] double occupancy(const Cell& cell) const { return to_probability(stored(cell)); }

  [[nodiscard]] Stored stored(const Cell& cell) const {
    const Tile* tile = tiles_.find(Tiles::tile_of(cell));
    return tile == nullptr ? kUnknown : (*tile)[Tiles::index_in_tile(cell)];
  }

  /// Moves the cell's probability towards `observed` by the fraction `quality`; both in [0, 1].
  /// Returns the new probability.
  double blend(const Cell& cell, double observed, double quality) {
    Stored& stored = touch(Tiles::tile_of(cell))[Tiles::index_in_tile(cell)];
    stored = blended(stored, kSteps * observed, quality);
    return to_probability(stored);
  }

  /// What `blend` makes of a cell; `observed` in steps of the stored form, 0...kSteps.
  [[nodiscard]] static Stored blended(Stored stored, double observed, double quality) {
    // Without a branch, so that a loop over cells can be vectorised.
    const int twice = 2 * stored - 2 + 65536 * static_cast<int>(stored == kUnknown);
    const double before = 0.5 * twice;
    return static_cast<Stored>(static_cast<int>(before + quality * (observed - before) + 1.5));
  }

  /// Gives the cell what `stored` of another grid said.
  void restore(const Cell& cell, Stored value) {
    touch(Tiles::tile_of(cell))[Tiles::index_in_tile(cell)] = value;
  }

  /// The tile for writing, by rows; unknown at first.
  Tile& touch(const Cell& tile);

  /// Smallest box around all observed cells; empty when there are none.
  [[nodiscard]] CellBox known_bounds() const;

  [[nodiscard]] const Tiles& tiles() const { return tiles_; }

  [[nodiscard]] std::size_t bytes() const { return tiles_.bytes(); }

  [[nodiscard]] static double to_probability(Stored stored) {
    return stored == kUnknown ? 0.5 : (stored - 1) / kSteps;
  }

 private:
  GridGeometry geometry_;
  Tiles tiles_;
};

}  // namespace matchbox_slam
