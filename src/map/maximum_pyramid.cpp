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

template <int kSize>
Square<kSize> read_square(const MaximumPyramid::Values& values, const Cell& corner) {
  Square<kSize> square;
  Cell tile_position = Tiles::tile_of(corner);
  const Plane* tile = values(tile_position);
  std::size_t i = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x, ++i) {
      const Cell cell{corner.x + x, corner.y + y};
      if (const Cell wanted = Tiles::tile_of(cell); wanted != tile_position) {
        tile_position = wanted;
        tile = values(wanted);
      }
      square[i] = tile == nullptr ? std::uint8_t{0} : (*tile)[Tiles::index_in_tile(cell)];
    }
  }
  return square;
}

MaximumPyramid::Values values_of(const Tiles& tiles) {
  return [&tiles](const Cell& tile) { return tiles.find(tile); };
}

void write(Tiles& tiles, const Cell& cell, std::uint8_t value) {
  static const Plane kBlank{};
  const Cell tile = Tiles::tile_of(cell);
  if (value != 0 || tiles.find(tile) != nullptr) {
    tiles.touch(tile, kBlank)[Tiles::index_in_tile(cell)] = value;
  }
}

/// Entries [corner, corner + kSize) of the bounds, from the plain maxima (or values) of their
/// level.
template <int kSize>
void write_bounds(const MaximumPyramid::Values& maxima, const Cell& corner, Tiles& bounds) {
  constexpr int kRead = kSize + 1;
  const Square<kRead> square = read_square<kRead>(maxima, corner);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * kRead + static_cast<std::size_t>(x);
      const std::uint8_t lower = std::max(square[i], square[i + 1]);
      const std::uint8_t upper = std::max(square[i + kRead], square[i + kRead + 1]);
      write(bounds, {corner.x + x, corner.y + y}, std::max(lower, upper));
    }
  }
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
  std::uint8_t whole = 0;
  for (int y = 0; y < kPerBlock; ++y) {
    for (int x = 0; x < kPerBlock; ++x) {
      std::uint8_t maximum = 0;
      for (int row = 4 * y; row < 4 * y + 4; ++row) {
        const auto* first = cells.data() + static_cast<std::ptrdiff_t>(row * kBlockSize + 4 * x);
        maximum = std::max(maximum, *std::max_element(first, first + 4));
      }
      write(maxima_[0], {block.x * kPerBlock + x, block.y * kPerBlock + y}, maximum);
      whole = std::max(whole, maximum);
    }
  }
  write(maxima_[1], block, whole);
}

void MaximumPyramid::update_bounds(const Cell& block, const Values& values) {
  constexpr int kPerBlock = kBlockSize / 4;
  write_bounds<kBlockSize>(values, {block.x * kBlockSize, block.y * kBlockSize}, bounds_[0]);
  write_bounds<kPerBlock>(values_of(maxima_[0]), {block.x * kPerBlock, block.y * kPerBlock},
                          bounds_[1]);
  write_bounds<1>(values_of(maxima_[1]), block, bounds_[2]);
}

}  // namespace matchbox_slam
