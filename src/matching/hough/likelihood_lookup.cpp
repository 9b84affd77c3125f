#include "matching/hough/likelihood_lookup.hpp"

#include <array>
#include <cmath>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

using Tiles = LikelihoodField::Tiles;

constexpr std::array<std::uint8_t, LikelihoodField::Tile::kCells> kNothing{};

// Sums are kept in so many interleaved parts, so that no addition waits for the one before.
constexpr std::size_t kPartialSums = 4;

/// Without branches, so that loops over it are vectorised.
inline int within(int value, int last) {
  const int positive = value > 0 ? value : 0;
  return positive < last ? positive : last;
}

struct TileLayout {
  double cells_per_metre;
  Cell first;
  int columns;
  int rows;
};

/// Where points lie: tile and cell within it. What lies outside is in the margin.
MATCHBOX_SIMD_CLONES void locate(const double* __restrict__ plus_x,
                                 const double* __restrict__ minus_x,
                                 const double* __restrict__ plus_y,
                                 const double* __restrict__ also_y, std::size_t count, double at_x,
                                 double at_y, const TileLayout& tiles,
                                 std::int32_t* __restrict__ tile, std::int32_t* __restrict__ cell) {
  const TileLayout layout = tiles;  // which no store may change
  const int last_column = layout.columns - 1;
  const int last_row = layout.rows - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const int x = cell_index((at_x + plus_x[i] - minus_x[i]) * layout.cells_per_metre);
    const int y = cell_index((at_y + plus_y[i] + also_y[i]) * layout.cells_per_metre);
    const int column = (x >> Tiles::kTileBits) - layout.first.x;
    const int row = (y >> Tiles::kTileBits) - layout.first.y;
    tile[i] = within(row, last_row) * layout.columns + within(column, last_column);
    cell[i] = ((y & Tiles::kTileMask) << Tiles::kTileBits) | (x & Tiles::kTileMask);
  }
}

}  // namespace

LikelihoodLookup::LikelihoodLookup(const LikelihoodField& field) : geometry_(field.geometry()) {
  const CellBox bounds = field.tiles().tile_bounds();
  first_tile_ = {bounds.min.x - 1, bounds.min.y - 1};
  columns_ = bounds.width() + 2;
  rows_ = bounds.height() + 2;
  tiles_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                kNothing.data());
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const auto* tile = field.tiles().find({first_tile_.x + column, first_tile_.y + row});
      if (tile != nullptr) {
        const std::size_t first =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
        tiles_[first + static_cast<std::size_t>(column)] = tile->likelihood.data();
      }
    }
  }
}

void LikelihoodLookup::turn(const HoughPoints& points, double theta) {
  const std::size_t count = points.size();
  for (auto* array : {&cosine_x_, &cosine_y_, &sine_x_, &sine_y_, &weight_}) {
    array->resize(count);
  }
  tile_.resize(count);
  cell_.resize(count);
  const double cosine = std::cos(theta);
  const double sine = std::sin(theta);
  total_weight_ = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    cosine_x_[i] = cosine * static_cast<double>(points.x[i]);
    cosine_y_[i] = cosine * static_cast<double>(points.y[i]);
    sine_x_[i] = sine * static_cast<double>(points.x[i]);
    sine_y_[i] = sine * static_cast<double>(points.y[i]);
    weight_[i] = static_cast<double>(points.weight[i]);
    total_weight_ += weight_[i];
  }
}

double LikelihoodLookup::mean_at(const Eigen::Vector2d& translation) {
  constexpr double kLargestLikelihood = 255.0;
  const std::size_t count = weight_.size();
  locate(cosine_x_.data(), sine_y_.data(), sine_x_.data(), cosine_y_.data(), count, translation.x(),
         translation.y(), {1.0 / geometry_.resolution(), first_tile_, columns_, rows_},
         tile_.data(), cell_.data());
  std::array<double, kPartialSums> sums{};
  const auto add = [&](std::size_t i, double& to) {
    to += weight_[i] * tiles_[static_cast<std::size_t>(tile_[i])][cell_[i]];
  };
  std::size_t i = 0;
  for (; i + kPartialSums <= count; i += kPartialSums) {
    for (std::size_t k = 0; k < kPartialSums; ++k) {
      add(i + k, sums[k]);
    }
  }
  for (; i < count; ++i) {
    add(i, sums[0]);
  }
  const double sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  return total_weight_ > 0.0 ? sum / (kLargestLikelihood * total_weight_) : 0.0;
}

}  // namespace matchbox_slam
