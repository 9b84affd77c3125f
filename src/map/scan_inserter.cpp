#include "matchbox_slam/map/scan_inserter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "map/scan_surfaces.hpp"

namespace matchbox_slam {
namespace {

/// What one scan says about the cells that it saw, before the map hears of it.
class Observations {
 public:
  using Tile = std::array<std::uint8_t, std::size_t{64} * 64>;
  using Tiles = TiledGrid<Tile, 6>;

  static constexpr std::uint8_t kUnseen = 0;
  static constexpr std::uint8_t kFreeNoReturn = 1;
  static constexpr std::uint8_t kFree = 2;
  static constexpr double kOccupiedSteps = 253.0;  // 3...255 are occupancies from just above 0 to 1

  [[nodiscard]] static std::uint8_t occupied(double occupancy) {
    return static_cast<std::uint8_t>(2 + std::lround(occupancy * kOccupiedSteps));
  }
  [[nodiscard]] static double occupancy(std::uint8_t mark) {
    return mark <= kFree ? 0.0 : (mark - 2) / kOccupiedSteps;
  }

  /// The most occupied observation of a cell wins.
  void mark(Cell cell, std::uint8_t value) {
    if (const Cell tile = Tiles::tile_of(cell); current_ == nullptr || tile != current_position_) {
      enter(tile);
    }
    std::uint8_t& marked = (*current_)[Tiles::index_in_tile(cell)];
    marked = std::max(marked, value);
  }

  [[nodiscard]] const Tiles& tiles() const { return tiles_; }

 private:
  /// Apart, so that `mark` stays small enough to become part of the loops that call it.
  [[gnu::noinline]] void enter(const Cell& tile) {
    static const Tile kBlank{};
    current_ = &tiles_.touch(tile, kBlank);
    current_position_ = tile;
  }

  Tiles tiles_;
  Tile* current_ = nullptr;  // consecutive cells of a ray mostly share their tile
  Cell current_position_;
};

/// Marks every cell that the segment from `a` to `b` crosses (Amanatides and Woo 1987).
void mark_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const GridGeometry& geometry,
                  std::uint8_t value, Observations& observations) {
  Cell cell = geometry.cell_at(a);
  const Cell end = geometry.cell_at(b);
  const Eigen::Vector2d step = b - a;
  const int step_x = step.x() < 0.0 ? -1 : 1;
  const int step_y = step.y() < 0.0 ? -1 : 1;
  const double per_cell_x = geometry.resolution() / std::max(std::abs(step.x()), 1e-12);
  const double per_cell_y = geometry.resolution() / std::max(std::abs(step.y()), 1e-12);
  const Eigen::Vector2d from_corner = (a - geometry.corner(cell)) / geometry.resolution();
  double next_x = (step_x > 0 ? 1.0 - from_corner.x() : from_corner.x()) * per_cell_x;
  double next_y = (step_y > 0 ? 1.0 - from_corner.y() : from_corner.y()) * per_cell_y;
  // The number of steps is known beforehand, so that rounding cannot make the walk miss its end.
  int left_x = std::abs(end.x - cell.x);
  int left_y = std::abs(end.y - cell.y);
  observations.mark(cell, value);
  while (left_x + left_y > 0) {
    // Without branches: nobody foretells where a line goes next.
    const int along_x = static_cast<int>((left_y == 0) | ((left_x > 0) & (next_x < next_y)));
    const int along_y = 1 - along_x;
    cell.x += along_x * step_x;
    cell.y += along_y * step_y;
    next_x += along_x * per_cell_x;
    next_y += along_y * per_cell_y;
    left_x -= along_x;
    left_y -= along_y;
    observations.mark(cell, value);
  }
}

/// A hit: free up to half a hole in front of it, then rising to an obstacle at the hit.
/// Deviation from tinySLAM: behind the hit the profile stops where it says rather free than
/// occupied, because nothing was seen there.
void mark_hit(const Eigen::Vector2d& origin, const Eigen::Vector2d& hit, double half_hole,
              const GridGeometry& geometry, Observations& observations) {
  const double range = (hit - origin).norm();
  const Eigen::Vector2d direction = (hit - origin) / std::max(range, 1e-9);
  const double free_length = range - half_hole;
  if (free_length > 0.0) {
    mark_segment(origin, origin + free_length * direction, geometry, Observations::kFree,
                 observations);
  }
  const double step = 0.5 * geometry.resolution();
  for (double offset = -std::min(half_hole, range); offset < 0.5 * half_hole; offset += step) {
    const double occupancy = 1.0 - std::abs(offset) / half_hole;
    observations.mark(geometry.cell_at(hit + offset * direction),
                      Observations::occupied(occupancy));
  }
  observations.mark(geometry.cell_at(hit), Observations::occupied(1.0));
}

Observations observe(const PointScan& scan, const std::vector<SurfaceHit>& wall_between,
                     const Pose2& map_from_base, const MapOptions& options) {
  const GridGeometry geometry(options.resolution);
  Observations observations;
  for (const FreeRay& ray : scan.free_rays) {
    mark_segment(map_from_base * ray.origin, map_from_base * ray.end, geometry,
                 Observations::kFreeNoReturn, observations);
  }
  for (const ScanPoint& point : scan.points) {
    mark_hit(map_from_base * point.origin, map_from_base * point.position, 0.5 * options.hole_width,
             geometry, observations);
  }
  // Far away the beams are wider apart than cells, and those grazing along a wall would erase it.
  for (const SurfaceHit& hit : wall_between) {
    observations.mark(geometry.cell_at(hit.position), Observations::occupied(1.0));
  }
  return observations;
}

/// Blends all observations into the map. Returns the cells that ceased to be occupied.
std::vector<Cell> blend(const Observations& observations, const MapOptions& options,
                        OccupancyGrid& occupancy) {
  constexpr int kSize = Observations::Tiles::kTileSize;
  std::vector<Cell> cleared;
  const CellBox tiles = observations.tiles().tile_bounds();
  for (int ty = tiles.min.y; ty < tiles.max.y; ++ty) {
    for (int tx = tiles.min.x; tx < tiles.max.x; ++tx) {
      const Observations::Tile* tile = observations.tiles().find({tx, ty});
      if (tile == nullptr) {
        continue;
      }
      for (int i = 0; i < kSize * kSize; ++i) {
        const std::uint8_t mark = (*tile)[static_cast<std::size_t>(i)];
        if (mark == Observations::kUnseen) {
          continue;
        }
        const Cell cell{tx * kSize + i % kSize, ty * kSize + i / kSize};
        const double before = occupancy.occupancy(cell);
        const double after = occupancy.blend(
            cell, Observations::occupancy(mark),
            mark == Observations::kFreeNoReturn ? options.no_return_quality : options.quality);
        if (before >= options.occupied_threshold && after < options.occupied_threshold) {
          cleared.push_back(cell);
        }
      }
    }
  }
  return cleared;
}

/// What a scan changes in the likelihood field.
struct FieldChange {
  std::vector<SurfaceHit> hits;
  std::vector<Cell> cleared;
};

FieldChange draw(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                 OccupancyGrid& occupancy) {
  std::vector<SurfaceHit> hits = surfaces_between_hits(scan, map_from_base, options.resolution);
  std::vector<Cell> cleared =
      blend(observe(scan, hits, map_from_base, options), options, occupancy);
  const std::vector<SurfaceHit> own = surfaces_at_hits(scan, map_from_base);
  hits.insert(hits.end(), own.begin(), own.end());
  const auto is_free = [&](const SurfaceHit& hit) {
    return occupancy.occupancy(occupancy.geometry().cell_at(hit.position)) <
           options.occupied_threshold;
  };
  hits.erase(std::remove_if(hits.begin(), hits.end(), is_free), hits.end());
  return {std::move(hits), std::move(cleared)};
}

}  // namespace

bool has_room(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
              const SlamMap& map) {
  constexpr int kSize = OccupancyGrid::Tiles::kTileSize;
  Eigen::AlignedBox2d box;
  const CellBox tiles = map.occupancy.tiles().tile_bounds();
  if (!tiles.empty()) {
    const double tile = kSize * options.resolution;
    box.extend(Eigen::Vector2d(tiles.min.x * tile, tiles.min.y * tile));
    box.extend(Eigen::Vector2d(tiles.max.x * tile, tiles.max.y * tile));
  }
  for (const ScanPoint& point : scan.points) {
    box.extend(map_from_base * point.origin);
    box.extend(map_from_base * point.position);
  }
  for (const FreeRay& ray : scan.free_rays) {
    box.extend(map_from_base * ray.origin);
    box.extend(map_from_base * ray.end);
  }
  const double cell_area = options.resolution * options.resolution;
  // A map as thin as a line has no area, and yet its tiles.
  const Eigen::Vector2d sides = box.sizes().array() + kSize * options.resolution;
  return box.isEmpty() || sides.x() * sides.y() <= options.max_cells * cell_area;
}

void insert_scan(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                 SlamMap& map) {
  const FieldChange change = draw(scan, map_from_base, options, map.occupancy);
  map.field.update(change.hits, change.cleared);
}

void insert_unrendered(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                       SlamMap& map) {
  const FieldChange change = draw(scan, map_from_base, options, map.occupancy);
  map.field.take(change.hits, change.cleared);
}

}  // namespace matchbox_slam
