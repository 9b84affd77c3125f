#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "matchbox_slam/map/grid_geometry.hpp"
#include "matchbox_slam/map/tiled_grid.hpp"

namespace matchbox_slam {

/// Upper bounds of a grid of bytes over square windows, at three scales: what exact search in many
/// resolutions prunes by. Level l has the stride s = 4^l cells; its entry (i, j) is the maximum
/// over the cells [i s, i s + 2 s) x [j s, j s + 2 s). The windows overlap by half, so whatever
/// cell of the block (i, j) a point lies in, the entry bounds the values that it meets on any shift
/// by up to s cells in x and in y. Maxima over blocks that do not overlap would bound only a point
/// in their lower left corner.
///
/// Kept up to date block by block, lowered too where values fall.
class MaximumPyramid {
 public:
  static constexpr int kLevels = 3;
  /// Changes are told in square blocks this many cells wide: one entry's worth of the top level.
  static constexpr int kBlockSize = 16;

  using Plane = std::array<std::uint8_t, std::size_t{64} * 64>;
  using Tiles = TiledGrid<Plane, 6>;
  /// The values of a 64 x 64 tile of cells, row by row, or null where all are 0.
  using Values = std::function<const Plane*(const Cell& tile)>;

  [[nodiscard]] static constexpr int stride(int level) { return 1 << (2 * level); }

  /// Takes over the changes within `blocks` (positions in blocks), given the values as they are
  /// now. Cost: the blocks and their neighbours to the left and below.
  void update(const std::vector<Cell>& blocks, const Values& values);

  /// Entries of a level, in units of its stride; a missing tile is 0.
  [[nodiscard]] const Tiles& level(int level) const {
    return bounds_[static_cast<std::size_t>(level)];
  }

  [[nodiscard]] std::size_t bytes() const;

 private:
  void update_block_maxima(const Cell& block, const Values& values);
  void update_bounds(const Cell& block, const Values& values);

  std::array<Tiles, kLevels> bounds_;
  std::array<Tiles, kLevels - 1> maxima_;  ///< of the plain blocks of levels 1 and 2
};

}  // namespace matchbox_slam
