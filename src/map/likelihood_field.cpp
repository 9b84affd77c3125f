#include "matchbox_slam/map/likelihood_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

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

/// A surface near a block, in cells from the block's corner.
struct Contestant {
  float x, y;
  std::int16_t cell_x, cell_y;
};

/// Of each cell of a block: row by row.
template <typename Value>
using OfBlock = std::array<Value, kBlockCells>;

/// Which of these is nearest to each cell of a block, into the tile's arrays from `index` on.
/// @param of_square  likelihood and distance, by steps of the squared distance and beyond them.
MATCHBOX_SIMD_CLONES void render_nearest(const Contestant* contestants, std::size_t count,
                                         float reach, int reach_rows,
                                         const std::uint16_t* of_square, std::size_t index,
                                         LikelihoodField::Tile& tile) {
  const float reach_square = reach * reach;
  alignas(64) OfBlock<float> squares;         // to the nearest surface
  alignas(64) OfBlock<std::int32_t> winners;  // its cell
  squares.fill(reach_square);
  winners.fill(0);
  for (const Contestant* it = contestants; it != contestants + count; ++it) {
    const std::int32_t cell = it->cell_y * 65536 + static_cast<std::uint16_t>(it->cell_x);
    alignas(64) std::array<float, kBlockSize> dx_square;
    // What is unrolled before it is vectorised takes one cell after the other.
#pragma GCC unroll 1
    for (std::size_t column = 0; column < kBlockSize; ++column) {
      const float dx = static_cast<float>(static_cast<int>(column)) + 0.5F - it->x;
      dx_square[column] = dx * dx;
    }
    const int last_row = std::min(kBlockSize - 1, it->cell_y + reach_rows);
    for (int row = std::max(0, it->cell_y - reach_rows); row <= last_row; ++row) {
      const float dy = static_cast<float>(row) + 0.5F - it->y;
      const float dy_square = dy * dy;
      float* square = squares.data() + std::ptrdiff_t{row} * kBlockSize;
      std::int32_t* winner = winners.data() + std::ptrdiff_t{row} * kBlockSize;
#pragma GCC unroll 1
      for (std::size_t column = 0; column < kBlockSize; ++column) {
        const float candidate = dx_square[column] + dy_square;
        const bool wins = candidate < square[column];
        square[column] = wins ? candidate : square[column];
        winner[column] = wins ? cell : winner[column];
      }
    }
  }
  const float steps = static_cast<float>(kSquareSteps) / reach_square;
  alignas(64) OfBlock<std::int32_t> step_of;
  for (std::size_t i = 0; i < kBlockCells; ++i) {
    const int step = std::min(static_cast<int>(squares[i] * steps), kSquareSteps - 1);
    step_of[i] = squares[i] < reach_square ? step : kSquareSteps;
  }
  for (std::size_t i = 0; i < kBlockCells; ++index) {
    const int row = static_cast<int>(i / kBlockSize);
    for (int column = 0; column < kBlockSize; ++column, ++i, ++index) {
      const bool is_near = step_of[i] < kSquareSteps;
      const std::uint16_t value = of_square[step_of[i]];
      tile.likelihood[index] = static_cast<std::uint8_t>(value);
      tile.distance[index] = static_cast<std::uint8_t>(value >> 8);
      const int x = static_cast<std::int16_t>(winners[i]) - column;
      const int y = (winners[i] >> 16) - row;
      tile.nearest_x[index] = static_cast<std::int8_t>(is_near ? x : 0);
      tile.nearest_y[index] = static_cast<std::int8_t>(is_near ? y : 0);
    }
    index += LikelihoodField::Tiles::kTileSize - kBlockSize - 1;
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
  const double steps = std::clamp(value, -1.0, 1.0) * 32767.0;
  return static_cast<std::int16_t>(steps + (steps < 0.0 ? -0.5 : 0.5));
}

double from_fixed(std::int16_t value) { return value / 32767.0; }

constexpr double kFacingSteps = 127.0;

/// As std::lround, of small numbers: that is a call.
int rounded(double value) {
  const int whole = static_cast<int>(value);
  const double rest = value - whole;
  return whole + static_cast<int>(rest >= 0.5) - static_cast<int>(rest <= -0.5);
}

/// A mean with one more value in it, in parts of 127: it stops within a quarter of where many lead.
std::int8_t mixed(std::int8_t mean, double value, double share) {
  return static_cast<std::int8_t>(
      rounded(mean + share * (kFacingSteps * std::clamp(value, -1.0, 1.0) - mean)));
}

}  // namespace

LikelihoodField::LikelihoodField(double resolution, const LikelihoodFieldOptions& options)
    : geometry_(resolution),
      options_(options),
      // Farther cells' centres are out of reach of any place in a cell.
      reach_cells_(static_cast<int>(options.reach / resolution + 0.501)),
      of_square_(kSquareSteps + 1, kFar << 8) {
  if (options.reach / resolution > 120.0) {
    throw ConfigurationError("field/reach: " + std::to_string(options.reach) +
                             " m is not allowed with cells of " + std::to_string(resolution) +
                             " m; allowed: at most 120 cells");
  }
  for (int i = 0; i < kSquareSteps; ++i) {
    const double distance = options.reach * std::sqrt((i + 0.5) / kSquareSteps);
    const double sigmas = distance / options.sigma;
    const long likelihood = std::lround(255.0 * std::exp(-0.5 * sigmas * sigmas));
    const long steps = std::min(254L, std::lround(255.0 * distance / options.reach));
    of_square_[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>((steps << 8) + likelihood);
  }
}

void LikelihoodField::update(const std::vector<SurfaceHit>& hits,
                             const std::vector<Cell>& cleared) {
  take(hits, cleared);
  render();
}

void LikelihoodField::take(const std::vector<SurfaceHit>& hits, const std::vector<Cell>& cleared) {
  for (const Cell& cell : cleared) {
    remove_surface(cell);
  }
  make_room_for(hits);
  for (const SurfaceHit& hit : hits) {
    add_hit(hit);
  }
  constexpr std::size_t kMostChanged = 1'000'000;
  if (changed_.size() > kMostChanged) {
    render();
  }
}

void LikelihoodField::settle() {
  for (const Cell& cell : changed_) {
    settle(cell);
  }
}

void LikelihoodField::render() {
  settle();
  render_changed();
}

void LikelihoodField::render_changed() {
  render_around(changed_);
  for (const Cell& cell : changed_) {
    touch_tile(cell).changed = 0;
  }
  changed_.clear();
}

void LikelihoodField::restore(const std::vector<std::pair<Cell, StoredSurface>>& surfaces) {
  *this = LikelihoodField(geometry_.resolution(), options_);
  for (const auto& [cell, surface] : surfaces) {
    if (surface.hits > 0) {
      touch_surface(cell) = surface;
    }
  }
  render_changed();
}

void LikelihoodField::render_around(const std::vector<Cell>& changed) {
  static const Tile kBlank = make_blank_tile();
  const auto reach = static_cast<float>(options_.reach / geometry_.resolution());
  std::vector<Contestant> contestants;
  for (const Cell& block : blocks_around(changed)) {
    const Cell corner{block.x * kBlockSize, block.y * kBlockSize};
    contestants.clear();
    visit_surfaces({{corner.x - reach_cells_, corner.y - reach_cells_},
                    {corner.x + kBlockSize + reach_cells_, corner.y + kBlockSize + reach_cells_}},
                   [&](const Cell& cell, const StoredSurface& surface) {
                     const Cell at{cell.x - corner.x, cell.y - corner.y};
                     contestants.push_back(
                         {static_cast<float>(at.x + 0.5 + 0.5 * from_fixed(surface.offset_x)),
                          static_cast<float>(at.y + 0.5 + 0.5 * from_fixed(surface.offset_y)),
                          static_cast<std::int16_t>(at.x), static_cast<std::int16_t>(at.y)});
                   });
    const Cell tile = Tiles::tile_of(corner);
    if (!contestants.empty() || tiles_.find(tile) != nullptr) {
      render_nearest(contestants.data(), contestants.size(), reach, reach_cells_, of_square_.data(),
                     Tiles::index_in_tile(corner), tiles_.touch(tile, kBlank));
    }
  }
}

LikelihoodField::SurfaceTile& LikelihoodField::touch_tile(const Cell& cell) {
  static const SurfaceTile kBlank{};
  return surfaces_.touch(SurfaceTiles::tile_of(cell), kBlank);
}

LikelihoodField::StoredSurface& LikelihoodField::touch_surface(const Cell& cell) {
  SurfaceTile& tile = touch_tile(cell);
  const std::size_t index = SurfaceTiles::index_in_tile(cell);
  const std::uint64_t bit = std::uint64_t{1} << index;
  surface_count_ += (tile.present & bit) == 0 ? 1U : 0U;
  tile.present |= bit;
  note_change(cell, tile);
  return tile.surfaces[index];
}

void LikelihoodField::note_change(const Cell& cell, SurfaceTile& tile) {
  const std::uint64_t bit = std::uint64_t{1} << SurfaceTiles::index_in_tile(cell);
  if ((tile.changed & bit) == 0) {
    tile.changed |= bit;
    changed_.push_back(cell);
  }
}

void LikelihoodField::make_room_for(const std::vector<SurfaceHit>& hits) {
  // So that a robot that drives on does not make all of it move with every scan.
  constexpr int kMargin = 16;  // tiles
  Eigen::AlignedBox2d box;
  for (const SurfaceHit& hit : hits) {
    box.extend(hit.position);
  }
  if (box.isEmpty()) {
    return;
  }
  const CellBox there = surfaces_.tile_bounds();
  const Cell first = SurfaceTiles::tile_of(geometry_.cell_at(box.min()));
  const Cell last = SurfaceTiles::tile_of(geometry_.cell_at(box.max()));
  if (!there.contains(first) || !there.contains(last)) {
    surfaces_.make_room({{first.x - (first.x < there.min.x ? kMargin : 0),
                          first.y - (first.y < there.min.y ? kMargin : 0)},
                         {last.x + 1 + (last.x >= there.max.x ? kMargin : 0),
                          last.y + 1 + (last.y >= there.max.y ? kMargin : 0)}});
  }
}

void LikelihoodField::add_hit(const SurfaceHit& hit) {
  const Cell cell = geometry_.cell_at(hit.position);
  StoredSurface& surface = touch_surface(cell);
  surface.hits = static_cast<std::uint16_t>(std::min(surface.hits + 1, kMostHits));
  const double share = 1.0 / surface.hits;
  const Eigen::Vector2d offset =
      (hit.position - geometry_.center(cell)) * (2.0 / geometry_.resolution());
  // (nx + i ny)^2 has twice the angle.
  const std::array<double, 4> values{
      offset.x(), offset.y(), hit.normal.x() * hit.normal.x() - hit.normal.y() * hit.normal.y(),
      2.0 * hit.normal.x() * hit.normal.y()};
  std::array<std::int16_t, 4> means{surface.offset_x, surface.offset_y, surface.mean_double_angle_x,
                                    surface.mean_double_angle_y};
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double before = from_fixed(means[i]);
    means[i] = to_fixed(before + share * (values[i] - before));
  }
  surface.offset_x = means[0];
  surface.offset_y = means[1];
  surface.mean_double_angle_x = means[2];
  surface.mean_double_angle_y = means[3];
  surface.facing_x = mixed(surface.facing_x, hit.normal.x(), share);
  surface.facing_y = mixed(surface.facing_y, hit.normal.y(), share);
}

/// What is said of a changed cell's surface once it has all its hits.
void LikelihoodField::settle(const Cell& cell) {
  StoredSurface& surface = touch_tile(cell).surfaces[SurfaceTiles::index_in_tile(cell)];
  const Eigen::Vector2d mean(from_fixed(surface.mean_double_angle_x),
                             from_fixed(surface.mean_double_angle_y));
  const double agreement = mean.norm();
  const double stretch = agreement > 0.0 ? std::min(1.0, agreement / kLine) / agreement : 0.0;
  surface.double_angle_x = to_fixed(stretch * mean.x());
  surface.double_angle_y = to_fixed(stretch * mean.y());
}

void LikelihoodField::remove_surface(const Cell& cell) {
  if (!has_surface(cell)) {
    return;
  }
  SurfaceTile& tile = touch_tile(cell);
  const std::size_t index = SurfaceTiles::index_in_tile(cell);
  tile.surfaces[index] = {};
  tile.present &= ~(std::uint64_t{1} << index);
  --surface_count_;
  note_change(cell, tile);
}

const LikelihoodField::StoredSurface* LikelihoodField::find_surface(const Cell& cell) const {
  const SurfaceTile* tile = surfaces_.find(SurfaceTiles::tile_of(cell));
  if (tile == nullptr) {
    return nullptr;
  }
  const StoredSurface& surface = tile->surfaces[SurfaceTiles::index_in_tile(cell)];
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
  surface.facing = Eigen::Vector2d(stored->facing_x, stored->facing_y) / kFacingSteps;
  surface.hits = stored->hits;
  return true;
}

std::vector<Cell> LikelihoodField::blocks_around(const std::vector<Cell>& changed) const {
  const auto block_at = [](int x, int y) { return Cell{x >> kBlockBits, y >> kBlockBits}; };
  CellBox box;
  for (const Cell& cell : changed) {
    box.include(block_at(cell.x - reach_cells_, cell.y - reach_cells_));
    box.include(block_at(cell.x + reach_cells_, cell.y + reach_cells_));
  }
  const auto width = static_cast<std::size_t>(box.width());
  std::vector<bool> is_due(width * static_cast<std::size_t>(box.height()));
  for (const Cell& cell : changed) {
    const Cell first = block_at(cell.x - reach_cells_, cell.y - reach_cells_);
    const Cell last = block_at(cell.x + reach_cells_, cell.y + reach_cells_);
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        is_due[static_cast<std::size_t>(y - box.min.y) * width +
               static_cast<std::size_t>(x - box.min.x)] = true;
      }
    }
  }
  std::vector<Cell> blocks;
  for (std::size_t i = 0; i < is_due.size(); ++i) {
    if (is_due[i]) {
      blocks.push_back(
          {box.min.x + static_cast<int>(i % width), box.min.y + static_cast<int>(i / width)});
    }
  }
  return blocks;
}

template <typename Visitor>
void LikelihoodField::visit_surfaces(const CellBox& box, Visitor&& visit) const {
  constexpr int kSize = SurfaceTiles::kTileSize;
  const Cell first = SurfaceTiles::tile_of(box.min);
  const Cell last = SurfaceTiles::tile_of({box.max.x - 1, box.max.y - 1});
  for (int ty = first.y; ty <= last.y; ++ty) {
    for (int tx = first.x; tx <= last.x; ++tx) {
      const SurfaceTile* tile = surfaces_.find({tx, ty});
      for (std::uint64_t left = tile == nullptr ? 0 : tile->present; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(__builtin_ctzll(left));
        const Cell cell{tx * kSize + static_cast<int>(i) % kSize,
                        ty * kSize + static_cast<int>(i) / kSize};
        if (box.contains(cell)) {
          visit(cell, tile->surfaces[i]);
        }
      }
    }
  }
}

std::vector<Cell> LikelihoodField::surface_cells() const {
  constexpr int kSize = SurfaceTiles::kTileSize;
  const CellBox tiles = surfaces_.tile_bounds();
  std::vector<Cell> cells;
  visit_surfaces(
      {{tiles.min.x * kSize, tiles.min.y * kSize}, {tiles.max.x * kSize, tiles.max.y * kSize}},
      [&cells](const Cell& cell, const StoredSurface&) { cells.push_back(cell); });
  return cells;
}

}  // namespace matchbox_slam
