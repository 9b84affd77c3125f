#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/map/maximum_pyramid.hpp"

namespace matchbox_slam {
namespace {

using Plane = MaximumPyramid::Plane;
using Tiles = MaximumPyramid::Tiles;

/// A grid of bytes that tells its pyramid of every change.
class Grid {
 public:
  void set(const std::vector<std::pair<Cell, std::uint8_t>>& changes) {
    std::vector<Cell> blocks;
    for (const auto& [cell, value] : changes) {
      tiles_.touch(Tiles::tile_of(cell), Plane{})[Tiles::index_in_tile(cell)] = value;
      blocks.push_back({cell.x >> 4, cell.y >> 4});
    }
    pyramid.update(blocks, [this](const Cell& tile) { return tiles_.find(tile); });
  }

  [[nodiscard]] std::uint8_t maximum(const Cell& corner, int size) const {
    std::uint8_t maximum = 0;
    for (int y = corner.y; y < corner.y + size; ++y) {
      for (int x = corner.x; x < corner.x + size; ++x) {
        maximum = std::max(maximum, value(tiles_, {x, y}));
      }
    }
    return maximum;
  }

  [[nodiscard]] static std::uint8_t value(const Tiles& tiles, const Cell& cell) {
    const Plane* tile = tiles.find(Tiles::tile_of(cell));
    return tile == nullptr ? std::uint8_t{0} : (*tile)[Tiles::index_in_tile(cell)];
  }

  MaximumPyramid pyramid;

 private:
  Tiles tiles_;
};

/// Every entry whose window may touch [-range, range) is what the definition says.
void expect_exact(const Grid& grid, int range) {
  for (int level = 0; level < MaximumPyramid::kLevels; ++level) {
    const int stride = MaximumPyramid::stride(level);
    for (int y = -range / stride - 2; y <= range / stride; ++y) {
      for (int x = -range / stride - 2; x <= range / stride; ++x) {
        ASSERT_EQ(Grid::value(grid.pyramid.level(level), {x, y}),
                  grid.maximum({x * stride, y * stride}, 2 * stride))
            << "level " << level << " entry " << x << ", " << y;
      }
    }
  }
}

TEST(MaximumPyramid, BoundsWindowsTwoStridesWide) {
  Grid grid;
  grid.set({{{0, 0}, 9}});
  for (int level = 0; level < MaximumPyramid::kLevels; ++level) {
    const auto at = [&](int x, int y) { return Grid::value(grid.pyramid.level(level), {x, y}); };
    EXPECT_EQ(at(0, 0), 9);
    EXPECT_EQ(at(-1, -1), 9);
    EXPECT_EQ(at(-2, 0), 0);
    EXPECT_EQ(at(1, 0), 0);
  }
}

TEST(MaximumPyramid, IsExactAfterAnyChanges) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Grid grid;
    for (int round = 0; round < 5; ++round) {
      std::vector<std::pair<Cell, std::uint8_t>> changes;
      for (int i = 0; i < 40; ++i) {
        const Cell cell{static_cast<int>(random.uniform(-40.0, 40.0)),
                        static_cast<int>(random.uniform(-40.0, 40.0))};
        // Values fall as often as they rise, half of them to nothing.
        const double value = random.uniform(-255.0, 256.0);
        changes.emplace_back(cell, static_cast<std::uint8_t>(std::max(0.0, value)));
      }
      grid.set(changes);
    }
    expect_exact(grid, 80);
  }
}

TEST(MaximumPyramid, TakesNoMemoryForNothing) {
  MaximumPyramid pyramid;
  pyramid.update({{0, 0}, {100, -100}}, [](const Cell&) { return nullptr; });
  EXPECT_EQ(pyramid.bytes(), 0U);
}

}  // namespace
}  // namespace matchbox_slam
