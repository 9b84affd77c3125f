#include "matchbox_slam/map/likelihood_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

// The unit of rendering. Small enough that one new surface costs little, large enough that the
// surfaces around it are gathered once for many cells.
constexpr int kBlockBits = 4;
constexpr int kBlockSize = 1 << kBlockBits;
constexpr std::size_t kBlockCells = std::size_t{kBlockSize} * kBlockSize;

// Of the tables by squared distance. By default one is 0.4 cm^2 and changes the likelihood by at
// most 1 %.
constexpr int kSquareSteps = 4096;

// A mean over at most this many hits, so that a surface can still move after any time. With 32 or
// 128 the errors of pairs and the relations of intel stay within 1 %.
constexpr int kMostHits = 64;

// Mean length of the double-angle vectors of normals from one straight wall, which their noise
// makes shorter than 1: with normals off by s it is exp(-2 s^2), 0.85 for 0.28 rad. With half or
// double of what is missing to 1 the median error of pairs stays within 1 %.
constexpr double kLine = 0.85;

struct BlockBuffer {
  alignas(64) std::array<float, kBlockCells> square;         // to the nearest surface, in cells
  alignas(64) std::array<std::int32_t, kBlockCells> winner;  // its number
};

/// Lets the surface at (x, y), in cells from the block's corner, win the cells that it is nearest
/// to.
MATCHBOX_SIMD_CLONES void compete(float x, float y, std::int32_t number, int first_row,
                                  int last_row, BlockBuffer& buffer) {
  for (int row = first_row; row <= last_row; ++row) {
    const float dy = static_cast<float>(row) + 0.5F - y;
    const float dy_square = dy * dy;
    const std::ptrdiff_t first = std::ptrdiff_t{row} * kBlockSize;
    float* square = buffer.square.data() + first;
    std::int32_t* winner = buffer.winner.data() + first;
    for (int column = 0; column < kBlockSize; ++column) {
      const float dx = static_cast<float>(column) + 0.5F - x;
      const float candidate = dx * dx + dy_square;
      const bool wins = candidate < square[column];
      square[column] = wins ? candidate : square[column];
      winner[column] = wins ? number : winner[column];
    }
  }
}

LikelihoodField::Tile make_blank_tile() {
  LikelihoodField::Tile tile;
  tile.likelihood.fill(0);
  tile.distance.fill(LikelihoodField::kFar);
  tile.nearest_x.fill(0);
  tile.nearest_y.fill(0);
  return tile;
}

std::int16_t to_fixed(double value) {
  return static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0, 1.0) * 32767.0));
}

double from_fixed(std::int16_t value) { return value / 32767.0; }

}  // namespace

LikelihoodField::LikelihoodField(double resolution, const LikelihoodFieldOptions& options)
    : geometry_(resolution),
      options_(options),
      reach_cells_(static_cast<int>(std::ceil(options.reach / resolution)) + 1),
      likelihood_of_square_(kSquareSteps),
      distance_of_square_(kSquareSteps) {
  if (options.reach / resolution > 120.0) {
    throw ConfigurationError("field/reach: " + std::to_string(options.reach) +
                             " m is not allowed with cells of " + std::to_string(resolution) +
                             " m; allowed: at most 120 cells");
  }
  for (int i = 0; i < kSquareSteps; ++i) {
    const double distance = options.reach * std::sqrt((i + 0.5) / kSquareSteps);
    const double sigmas = distance / options.sigma;
    likelihood_of_square_[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * sigmas * sigmas)));
    distance_of_square_[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::min(254L, std::lround(255.0 * distance / options.reach)));
  }
}

void LikelihoodField::update(const std::vector<SurfaceHit>& hits,
                             const std::vector<Cell>& cleared) {
  take(hits, cleared);
  render();
}

void LikelihoodField::take(const std::vector<SurfaceHit>& hits, const std::vector<Cell>& cleared) {
  changed_.reserve(changed_.size() + hits.size() + cleared.size());
  for (const Cell& cell : cleared) {
    if (remove_surface(cell)) {
      changed_.push_back(cell);
    }
  }
  for (const SurfaceHit& hit : hits) {
    add_hit(hit);
    changed_.push_back(geometry_.cell_at(hit.position));
  }
  constexpr std::size_t kMostChanged = 1'000'000;
  if (changed_.size() > kMostChanged) {
    render();
  }
}

void LikelihoodField::render() {
  render_around(std::move(changed_));
  changed_.clear();
}

void LikelihoodField::restore(const std::vector<std::pair<Cell, StoredSurface>>& surfaces) {
  static const SurfaceTile kBlank{};
  *this = LikelihoodField(geometry_.resolution(), options_);
  std::vector<Cell> cells;
  cells.reserve(surfaces.size());
  for (const auto& [cell, surface] : surfaces) {
    StoredSurface& kept =
        surfaces_.touch(SurfaceTiles::tile_of(cell), kBlank)[SurfaceTiles::index_in_tile(cell)];
    surface_count_ += kept.hits == 0 && surface.hits > 0 ? 1U : 0U;
    kept = surface;
    cells.push_back(cell);
  }
  render_around(std::move(cells));
}

void LikelihoodField::render_around(std::vector<Cell> changed) {
  for (const Cell& block : blocks_around(std::move(changed))) {
    render_block(block);
  }
}

void LikelihoodField::add_hit(const SurfaceHit& hit) {
  static const SurfaceTile kBlank{};
  const Cell cell = geometry_.cell_at(hit.position);
  StoredSurface& surface =
      surfaces_.touch(SurfaceTiles::tile_of(cell), kBlank)[SurfaceTiles::index_in_tile(cell)];
  if (surface.hits == 0) {
    ++surface_count_;
  }
  surface.hits = static_cast<std::uint16_t>(std::min(surface.hits + 1, kMostHits));
  const double share = 1.0 / surface.hits;
  const auto blend = [share](std::int16_t& mean, double value) {
    const double before = from_fixed(mean);
    mean = to_fixed(before + share * (value - before));
  };
  const Eigen::Vector2d offset =
      (hit.position - geometry_.center(cell)) * (2.0 / geometry_.resolution());
  blend(surface.offset_x, offset.x());
  blend(surface.offset_y, offset.y());
  // (nx + i ny)^2 has twice the angle.
  blend(surface.mean_double_angle_x,
        hit.normal.x() * hit.normal.x() - hit.normal.y() * hit.normal.y());
  blend(surface.mean_double_angle_y, 2.0 * hit.normal.x() * hit.normal.y());
  const Eigen::Vector2d mean(from_fixed(surface.mean_double_angle_x),
                             from_fixed(surface.mean_double_angle_y));
  const double agreement = mean.norm();
  const double stretch = agreement > 0.0 ? std::min(1.0, agreement / kLine) / agreement : 0.0;
  surface.double_angle_x = to_fixed(stretch * mean.x());
  surface.double_angle_y = to_fixed(stretch * mean.y());
}

bool LikelihoodField::remove_surface(const Cell& cell) {
  if (!has_surface(cell)) {
    return false;
  }
  static const SurfaceTile kBlank{};
  surfaces_.touch(SurfaceTiles::tile_of(cell), kBlank)[SurfaceTiles::index_in_tile(cell)] = {};
  --surface_count_;
  return true;
}

const LikelihoodField::StoredSurface* LikelihoodField::find_surface(const Cell& cell) const {
  const SurfaceTile* tile = surfaces_.find(SurfaceTiles::tile_of(cell));
  if (tile == nullptr) {
    return nullptr;
  }
  const StoredSurface& surface = (*tile)[SurfaceTiles::index_in_tile(cell)];
  return surface.hits == 0 ? nullptr : &surface;
}

bool LikelihoodField::has_surface(const Cell& cell) const { return find_surface(cell) != nullptr; }

bool LikelihoodField::nearest_surface(const Cell& cell, Surface& surface) const {
  const Tile* tile = tiles_.find(Tiles::tile_of(cell));
  if (tile == nullptr) {
    return false;
  }
  const std::size_t index = Tiles::index_in_tile(cell);
  if (tile->distance[index] == kFar) {
    return false;
  }
  const Cell nearest{cell.x + tile->nearest_x[index], cell.y + tile->nearest_y[index]};
  const StoredSurface* stored = find_surface(nearest);
  if (stored == nullptr) {
    return false;
  }
  const double half_cell = 0.5 * geometry_.resolution();
  surface.position =
      geometry_.center(nearest) +
      half_cell * Eigen::Vector2d(from_fixed(stored->offset_x), from_fixed(stored->offset_y));
  surface.double_angle = {from_fixed(stored->double_angle_x), from_fixed(stored->double_angle_y)};
  surface.hits = stored->hits;
  return true;
}

std::vector<Cell> LikelihoodField::blocks_around(std::vector<Cell> changed) const {
  const auto by_row = [](const Cell& a, const Cell& b) {
    return std::tie(a.y, a.x) < std::tie(b.y, b.x);
  };
  const auto make_unique = [&](std::vector<Cell>& cells) {
    std::sort(cells.begin(), cells.end(), by_row);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  };
  make_unique(changed);
  std::vector<Cell> blocks;
  blocks.reserve(4 * changed.size());
  for (const Cell& cell : changed) {
    for (int y = (cell.y - reach_cells_) >> kBlockBits; y <= (cell.y + reach_cells_) >> kBlockBits;
         ++y) {
      for (int x = (cell.x - reach_cells_) >> kBlockBits;
           x <= (cell.x + reach_cells_) >> kBlockBits; ++x) {
        blocks.push_back({x, y});
      }
    }
  }
  make_unique(blocks);
  return blocks;
}

std::vector<Cell> LikelihoodField::surfaces_in(const CellBox& box) const {
  constexpr int kSize = SurfaceTiles::kTileSize;
  std::vector<Cell> cells;
  const Cell first = SurfaceTiles::tile_of(box.min);
  const Cell last = SurfaceTiles::tile_of({box.max.x - 1, box.max.y - 1});
  for (int ty = first.y; ty <= last.y; ++ty) {
    for (int tx = first.x; tx <= last.x; ++tx) {
      const SurfaceTile* tile = surfaces_.find({tx, ty});
      if (tile == nullptr) {
        continue;
      }
      for (int i = 0; i < kSize * kSize; ++i) {
        const Cell cell{tx * kSize + i % kSize, ty * kSize + i / kSize};
        if ((*tile)[static_cast<std::size_t>(i)].hits > 0 && box.contains(cell)) {
          cells.push_back(cell);
        }
      }
    }
  }
  return cells;
}

std::vector<Cell> LikelihoodField::surface_cells() const {
  constexpr int kSize = SurfaceTiles::kTileSize;
  const CellBox tiles = surfaces_.tile_bounds();
  if (tiles.empty()) {
    return {};
  }
  return surfaces_in(
      {{tiles.min.x * kSize, tiles.min.y * kSize}, {tiles.max.x * kSize, tiles.max.y * kSize}});
}

void LikelihoodField::render_block(const Cell& block) {
  static const Tile kBlank = make_blank_tile();
  const Cell corner{block.x * kBlockSize, block.y * kBlockSize};
  const std::vector<Cell> surfaces =
      surfaces_in({{corner.x - reach_cells_, corner.y - reach_cells_},
                   {corner.x + kBlockSize + reach_cells_, corner.y + kBlockSize + reach_cells_}});
  const Cell tile_position = Tiles::tile_of(corner);
  if (surfaces.empty() && tiles_.find(tile_position) == nullptr) {
    return;
  }
  const auto reach = static_cast<float>(options_.reach / geometry_.resolution());
  const float reach_square = reach * reach;
  BlockBuffer buffer;
  buffer.square.fill(reach_square);
  buffer.winner.fill(-1);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const StoredSurface& surface = *find_surface(surfaces[i]);
    const Cell from_corner{surfaces[i].x - corner.x, surfaces[i].y - corner.y};
    compete(static_cast<float>(from_corner.x + 0.5 + 0.5 * from_fixed(surface.offset_x)),
            static_cast<float>(from_corner.y + 0.5 + 0.5 * from_fixed(surface.offset_y)),
            static_cast<std::int32_t>(i), std::max(0, from_corner.y - reach_cells_),
            std::min(kBlockSize - 1, from_corner.y + reach_cells_), buffer);
  }
  Tile& tile = tiles_.touch(tile_position, kBlank);
  const float steps = static_cast<float>(kSquareSteps) / reach_square;
  for (std::size_t i = 0; i < kBlockCells; ++i) {
    const int number = static_cast<int>(i);
    const Cell cell{corner.x + number % kBlockSize, corner.y + number / kBlockSize};
    const std::size_t index = Tiles::index_in_tile(cell);
    const std::int32_t winner = buffer.winner[i];
    if (winner < 0) {
      tile.likelihood[index] = 0;
      tile.distance[index] = kFar;
      tile.nearest_x[index] = 0;
      tile.nearest_y[index] = 0;
      continue;
    }
    const auto step = std::min(static_cast<std::size_t>(buffer.square[i] * steps),
                               static_cast<std::size_t>(kSquareSteps - 1));
    const Cell& nearest = surfaces[static_cast<std::size_t>(winner)];
    tile.likelihood[index] = likelihood_of_square_[step];
    tile.distance[index] = distance_of_square_[step];
    tile.nearest_x[index] = static_cast<std::int8_t>(nearest.x - cell.x);
    tile.nearest_y[index] = static_cast<std::int8_t>(nearest.y - cell.y);
  }
}

}  // namespace matchbox_slam
