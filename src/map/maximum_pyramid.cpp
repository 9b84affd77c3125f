#include "matchbox_slam/map/maximum_pyramid.hpp"

#include <algorithm>
#include <tuple>

namespace matchbox_slam {
namespace {

using Plane = MaximumPyramid::Plane;
using Tiles = MaximumPyramid::Tiles;

/// The square of entries [corner, corner + kSize) of a grid, row by row.
template <int kSize>
using Square = std::array<std::uint8_t, static_cast<std::size_t>(kSize* kSize)>;

/// Tile by tile, row by row; what has no tile is 0.
template <int kSize>
Square<kSize> read_square(const MaximumPyramid::Values& values, const Cell& corner) {
  static_assert(kSize <= Tiles::kTileSize);
  Square<kSize> square{};
  const Cell last = Tiles::tile_of({corner.x + kSize - 1, corner.y + kSize - 1});
  for (int ty = Tiles::tile_of(corner).y; ty <= last.y; ++ty) {
    for (int tx = Tiles::tile_of(corner).x; tx <= last.x; ++tx) {
      const Plane* tile = values({tx, ty});
      if (tile == nullptr) {
        continue;
      }
      const int first_x = std::max(0, tx * Tiles::kTileSize - corner.x);
      const int end_x = std::min(kSize, (tx + 1) * Tiles::kTileSize - corner.x);
      const int end_y = std::min(kSize, (ty + 1) * Tiles::kTileSize - corner.y);
      for (int y = std::max(0, ty * Tiles::kTileSize - corner.y); y < end_y; ++y) {
        const std::size_t from = Tiles::index_in_tile({corner.x + first_x, corner.y + y});
        std::copy_n(tile->data() + from, end_x - first_x, square.data() + y * kSize + first_x);
      }
    }
  }
  return square;
}

MaximumPyramid::Values values_of(const Tiles& tiles) {
  return [&tiles](const Cell& tile) { return tiles.find(tile); };
}

/// Writes entries that lie in one tile.
template <int kSize>
void write_square(Tiles& tiles, const Cell& corner, const Square<kSize>& square) {
  static const Plane kBlank{};
  const Cell position = Tiles::tile_of(corner);
  const bool is_blank = std::all_of(square.begin(), square.end(), [](int v) { return v == 0; });
  if (is_blank && tiles.find(position) == nullptr) {
    return;
  }
  Plane& tile = tiles.touch(position, kBlank);
  for (int y = 0; y < kSize; ++y) {
    std::copy_n(square.data() + y * kSize, kSize,
                tile.data() + Tiles::index_in_tile({corner.x, corner.y + y}));
  }
}

/// Entries [corner, corner + kSize) of the bounds, from the plain maxima (or values) of their
/// level.
template <int kSize>
void write_bounds(const MaximumPyramid::Values& maxima, const Cell& corner, Tiles& bounds) {
  constexpr int kRead = kSize + 1;
  const Square<kRead> square = read_square<kRead>(maxima, corner);
  Square<kSize> maximum;
  for (int y = 0; y < kSize; ++y) {
    const std::uint8_t* row = square.data() + y * kRead;
    for (int x = 0; x < kSize; ++x) {
      const std::uint8_t lower = std::max(row[x], row[x + 1]);
      const std::uint8_t upper = std::max(row[x + kRead], row[x + kRead + 1]);
      maximum[static_cast<std::size_t>(y * kSize + x)] = std::max(lower, upper);
    }
  }
  write_square<kSize>(bounds, corner, maximum);
}

/// The blocks, and those whose windows reach into them.
std::vector<Cell> with_neighbours(const std::vector<Cell>& blocks) {
  std::vector<Cell> all;
  all.reserve(4 * blocks.size());
  for (const Cell& block : blocks) {
    for (const Cell& offset : {Cell{0, 0}, Cell{-1, 0}, Cell{0, -1}, Cell{-1, -1}}) {
      all.push_back({block.x + offset.x, block.y + offset.y});
    }
  }
  std::sort(all.begin(), all.end(),
            [](const Cell& a, const Cell& b) { return std::tie(a.y, a.x) < std::tie(b.y, b.x); });
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

void MaximumPyramid::update(const std::vector<Cell>& blocks, const Values& values) {
  for (const Cell& block : blocks) {
    update_block_maxima(block, values);
  }
  for (const Cell& block : with_neighbours(blocks)) {
    update_bounds(block, values);
  }
}

std::size_t MaximumPyramid::bytes() const {
  std::size_t sum = 0;
  for (const Tiles& tiles : bounds_) {
    sum += tiles.bytes();
  }
  for (const Tiles& tiles : maxima_) {
    sum += tiles.bytes();
  }
  return sum;
}

void MaximumPyramid::update_block_maxima(const Cell& block, const Values& values) {
  constexpr int kPerBlock = kBlockSize / 4;
  const Square<kBlockSize> cells =
      read_square<kBlockSize>(values, {block.x * kBlockSize, block.y * kBlockSize});
  Square<kPerBlock> maxima{};
  for (int y = 0; y < kPerBlock; ++y) {
    for (int x = 0; x < kPerBlock; ++x) {
      std::uint8_t maximum = 0;
      for (int row = 4 * y; row < 4 * y + 4; ++row) {
        const auto* first = cells.data() + static_cast<std::ptrdiff_t>(row * kBlockSize + 4 * x);
        maximum = std::max(maximum, *std::max_element(first, first + 4));
      }
      maxima[static_cast<std::size_t>(y * kPerBlock + x)] = maximum;
    }
  }
  write_square<kPerBlock>(maxima_[0], {block.x * kPerBlock, block.y * kPerBlock}, maxima);
  write_square<1>(maxima_[1], block, {*std::max_element(maxima.begin(), maxima.end())});
}

void MaximumPyramid::update_bounds(const Cell& block, const Values& values) {
  constexpr int kPerBlock = kBlockSize / 4;
  write_bounds<kBlockSize>(values, {block.x * kBlockSize, block.y * kBlockSize}, bounds_[0]);
  write_bounds<kPerBlock>(values_of(maxima_[0]), {block.x * kPerBlock, block.y * kPerBlock},
                          bounds_[1]);
  write_bounds<1>(values_of(maxima_[1]), block, bounds_[2]);
}

}  // namespace matchbox_slam
