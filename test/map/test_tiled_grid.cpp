#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/map/tiled_grid.hpp"

namespace matchbox_slam {
namespace {

using Tile = std::array<int, 16>;
using Grid = TiledGrid<Tile, 2>;

constexpr Tile kBlank{};

void write(Grid& grid, const Cell& cell, int value) {
  grid.touch(Grid::tile_of(cell), kBlank)[Grid::index_in_tile(cell)] = value;
}

int read(const Grid& grid, const Cell& cell) {
  const Tile* tile = grid.find(Grid::tile_of(cell));
  return tile == nullptr ? -1 : (*tile)[Grid::index_in_tile(cell)];
}

TEST(TiledGrid, RoundsNegativeCellsDown) {
  EXPECT_EQ(Grid::tile_of({0, 3}), (Cell{0, 0}));
  EXPECT_EQ(Grid::tile_of({4, -1}), (Cell{1, -1}));
  EXPECT_EQ(Grid::tile_of({-4, -5}), (Cell{-1, -2}));
  EXPECT_EQ(Grid::index_in_tile({0, 0}), 0U);
  EXPECT_EQ(Grid::index_in_tile({-1, -1}), 15U);
  EXPECT_EQ(Grid::index_in_tile({-4, -3}), 4U);  // row 1, column 0
}

TEST(TiledGrid, IsEmptyAtFirst) {
  const Grid grid;
  EXPECT_EQ(grid.find({0, 0}), nullptr);
  EXPECT_TRUE(grid.tile_bounds().empty());
  EXPECT_EQ(grid.tile_count(), 0U);
  EXPECT_EQ(grid.bytes(), 0U);
}

TEST(TiledGrid, MakesMissingTilesFromTheBlankOne) {
  Tile blank;
  blank.fill(7);
  Grid grid;
  grid.touch({2, -3}, blank)[5] = 1;
  EXPECT_EQ((*grid.find({2, -3}))[4], 7);
  EXPECT_EQ(grid.touch({2, -3}, kBlank)[5], 1) << "an existing tile is kept";
}

TEST(TiledGrid, MakesRoomForABoxAtOnce) {
  Grid grid;
  write(grid, {5, -2}, 7);
  const Tile* tile = grid.find({1, -1});
  grid.make_room({{-3, -2}, {5, 4}});
  EXPECT_EQ(grid.tile_bounds().min, (Cell{-3, -2}));
  EXPECT_EQ(grid.tile_bounds().max, (Cell{5, 4}));
  EXPECT_EQ(grid.find({1, -1}), tile);
  EXPECT_EQ(read(grid, {5, -2}), 7);
  EXPECT_EQ(grid.tile_count(), 1U);
  const std::size_t bytes = grid.bytes();
  grid.make_room({{0, 0}, {2, 2}});
  EXPECT_EQ(grid.bytes(), bytes) << "there was room";
  EXPECT_EQ(grid.find({1, -1}), tile);
}

TEST(TiledGrid, GrowsInAllDirectionsAndKeepsWhatItHolds) {
  Grid grid;
  std::map<std::pair<int, int>, int> expected;
  Random random(3);
  for (int i = 1; i <= 3000; ++i) {
    const int reach = 1 + i / 20;
    const Cell cell{static_cast<int>(random.uniform(-reach, reach)),
                    static_cast<int>(random.uniform(-reach, reach))};
    write(grid, cell, i);
    expected[{cell.x, cell.y}] = i;
  }
  CellBox bounds{{0, 0}, {0, 0}};
  for (const auto& [cell, value] : expected) {
    ASSERT_EQ(read(grid, {cell.first, cell.second}), value);
    const Cell tile = Grid::tile_of({cell.first, cell.second});
    bounds.min = {std::min(bounds.min.x, tile.x), std::min(bounds.min.y, tile.y)};
    bounds.max = {std::max(bounds.max.x, tile.x + 1), std::max(bounds.max.y, tile.y + 1)};
  }
  EXPECT_EQ(grid.tile_bounds().min, bounds.min);
  EXPECT_EQ(grid.tile_bounds().max, bounds.max);
}

TEST(TiledGrid, FindsNothingOutsideItsBounds) {
  Grid grid;
  write(grid, {-5, 2}, 1);
  write(grid, {6, 9}, 2);
  for (const Cell tile : {Cell{-3, 0}, Cell{2, 0}, Cell{0, -1}, Cell{0, 3}, Cell{1 << 29, 0},
                          Cell{-(1 << 29), 1 << 29}, Cell{-1, 0}}) {
    EXPECT_EQ(grid.find(tile), nullptr) << tile.x << ", " << tile.y;
  }
}

TEST(TiledGrid, CopiesAreIndependentBothWays) {
  Grid original;
  write(original, {1, 1}, 10);
  write(original, {-9, 20}, 20);
  Grid copy = original;
  write(original, {1, 1}, 11);
  write(original, {50, 50}, 30);  // grows only one of them
  EXPECT_EQ(read(copy, {1, 1}), 10);
  EXPECT_EQ(read(copy, {50, 50}), -1);
  write(copy, {-9, 20}, 21);
  EXPECT_EQ(read(original, {-9, 20}), 20);
  const Grid second = copy;
  write(copy, {-9, 20}, 22);
  EXPECT_EQ(read(second, {-9, 20}), 21);
  EXPECT_EQ(read(original, {1, 1}), 11);
}

TEST(TiledGrid, CopiesShareTilesUntilOneIsWritten) {
  Grid original;
  write(original, {0, 0}, 1);
  write(original, {4, 0}, 2);
  const Grid copy = original;
  EXPECT_EQ(copy.find({0, 0}), original.find({0, 0}));
  write(original, {0, 0}, 3);
  EXPECT_NE(copy.find({0, 0}), original.find({0, 0}));
  EXPECT_EQ(copy.find({1, 0}), original.find({1, 0}));
}

TEST(TiledGrid, TakesMemoryForTilesThatWereWrittenToOnly) {
  Grid grid;
  write(grid, {0, 0}, 1);
  const std::size_t one = grid.bytes();
  EXPECT_GE(one, sizeof(Tile));
  write(grid, {3, 3}, 1);  // the same tile
  EXPECT_EQ(grid.bytes(), one);
  write(grid, {39, 0}, 1);  // ten tiles away
  EXPECT_EQ(grid.tile_count(), 2U);
  EXPECT_LE(grid.bytes(), 2 * sizeof(Tile) + std::size_t{10} * 2 * sizeof(void*));
}

}  // namespace
}  // namespace matchbox_slam
