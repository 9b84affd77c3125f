#include "matchbox_slam/map/scan_inserter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/simd.hpp"
#include "map/scan_surfaces.hpp"
#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

constexpr int kTileSize = OccupancyGrid::Tiles::kTileSize;

/// What one scan says about the cells that it saw, before the map hears of it.
class Observations {
 public:
  /// Rows lie two tiles apart, so that a step out of the tile shows in the position's bits.
  static constexpr int kPitch = 2 * kTileSize;
  using Tile = std::array<std::uint8_t, static_cast<std::size_t>(kPitch* kTileSize)>;
  using Tiles = TiledGrid<Tile, OccupancyGrid::Tiles::kTileBits>;

  static constexpr std::uint8_t kUnseen = 0;
  static constexpr std::uint8_t kFreeNoReturn = 1;
  static constexpr std::uint8_t kFree = 2;
  static constexpr double kOccupiedSteps = 253.0;  // 3...255 are occupancies from just above 0 to 1

  explicit Observations(double resolution) : geometry_(resolution) {}

  [[nodiscard]] static std::uint8_t occupied(double occupancy) {
    return static_cast<std::uint8_t>(2 + std::lround(occupancy * kOccupiedSteps));
  }

  /// The most occupied observation of a cell wins.
  void mark(const Eigen::Vector2d& point, std::uint8_t value) {
    const Cell cell = geometry_.cell_at(point);
    enter(Tiles::tile_of(cell));
    std::uint8_t& marked = (*current_)[static_cast<std::size_t>(position_in_tile(cell))];
    marked = std::max(marked, value);
  }

  /// Marks every cell that the segment from `a` to `b` crosses (Amanatides and Woo 1987), whatever
  /// was seen there.
  void mark_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::uint8_t value);

  [[nodiscard]] const Tiles& tiles() const { return tiles_; }

 private:
  [[nodiscard]] static int position_in_tile(const Cell& cell) {
    return (cell.y & Tiles::kTileMask) * kPitch + (cell.x & Tiles::kTileMask);
  }

  void enter(const Cell& tile) {
    if (current_ == nullptr || tile != current_position_) {
      static const Tile kBlank{};
      current_ = &tiles_.touch(tile, kBlank);
      current_position_ = tile;
    }
  }

  GridGeometry geometry_;
  Tiles tiles_;
  Tile* current_ = nullptr;  // consecutive cells of a ray mostly share their tile
  Cell current_position_;
};

void Observations::mark_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                std::uint8_t value) {
  const Cell cell = geometry_.cell_at(a);
  const Cell end = geometry_.cell_at(b);
  const Eigen::Vector2d way = (b - a).cwiseAbs();
  const int step_x = b.x() < a.x() ? -1 : 1;
  const int step_y = b.y() < a.y() ? -1 : 1;
  const Eigen::Vector2d from_corner = (a - geometry_.corner(cell)) / geometry_.resolution();
  const double to_next_x = step_x > 0 ? 1.0 - from_corner.x() : from_corner.x();
  const double to_next_y = step_y > 0 ? 1.0 - from_corner.y() : from_corner.y();
  // Where the line's next edges in x and in y are, on a common scale, and which comes first: in
  // integers, since with them a step waits a third as long for the one before.
  const double scale = 0x1p60 / std::max(way.maxCoeff(), 1e-12);
  auto per_x = static_cast<std::int64_t>(scale * way.y());
  auto per_y = static_cast<std::int64_t>(scale * way.x());
  auto x_after_y = static_cast<std::int64_t>(scale * (to_next_x * way.y() - to_next_y * way.x()));
  // The number of steps is known beforehand, so that rounding cannot make the walk miss its end.
  int left = std::abs(end.x - cell.x) + std::abs(end.y - cell.y);
  if (end.x == cell.x) {
    per_y = 0;
    x_after_y = 0;
  } else if (end.y == cell.y) {
    per_x = 0;
    x_after_y = -1;
  }
  const int move_x = step_x;
  const int move_y = step_y * kPitch;
  constexpr int kInside = (kTileSize - 1) * (kPitch + 1);
  Cell tile = Tiles::tile_of(cell);
  int position = position_in_tile(cell);
  while (true) {
    enter(tile);
    std::uint8_t* const marks = current_->data();
    std::int64_t along_x = 0;  // all bits set, or none
    do {
      marks[position] = value;
      if (left-- == 0) {
        return;
      }
      // Without branches: nobody foretells where a line goes next.
      along_x = x_after_y >> 63;
      x_after_y += (along_x & (per_x + per_y)) - per_y;
      position += (static_cast<int>(along_x) & (move_x - move_y)) + move_y;
    } while ((position & ~kInside) == 0);
    if (along_x != 0) {
      tile.x += step_x;
      position -= step_x * kTileSize;
    } else {
      tile.y += step_y;
      position -= move_y * kTileSize;
    }
  }
}

/// A hit: free up to half a hole in front of it, then rising to an obstacle at the hit.
/// Deviation from tinySLAM: behind the hit the profile stops where it says rather free than
/// occupied, because nothing was seen there.
struct Hole {
  Hole(double half_width, double resolution) : half(half_width) {
    for (double offset = -half; offset < 0.5 * half; offset += 0.5 * resolution) {
      marks.emplace_back(offset, Observations::occupied(1.0 - std::abs(offset) / half));
    }
    marks.emplace_back(0.0, Observations::occupied(1.0));
  }

  double half;                                         ///< of the width [m]
  std::vector<std::pair<double, std::uint8_t>> marks;  ///< by the way beyond the hit [m]
};

Observations observe(const PointScan& scan, const std::vector<SurfaceHit>& wall_between,
                     const Pose2& map_from_base, const MapOptions& options) {
  const Transform2 to_map(map_from_base);
  const Hole hole(0.5 * options.hole_width, options.resolution);
  Observations observations(options.resolution);
  for (const FreeRay& ray : scan.free_rays) {
    observations.mark_segment(to_map * ray.origin, to_map * ray.end, Observations::kFreeNoReturn);
  }
  // What is more occupied comes later.
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d origin = to_map * point.origin;
    const Eigen::Vector2d way = to_map * point.position - origin;
    const double range = way.norm();
    if (range > hole.half) {
      observations.mark_segment(origin, origin + (range - hole.half) * (way / range),
                                Observations::kFree);
    }
  }
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d hit = to_map * point.position;
    const Eigen::Vector2d way = hit - to_map * point.origin;
    const double range = way.norm();
    const Eigen::Vector2d direction = way / std::max(range, 1e-9);
    for (const auto& [offset, value] : hole.marks) {
      if (offset >= -range) {
        observations.mark(hit + offset * direction, value);
      }
    }
  }
  // Far away the beams are wider apart than cells, and those grazing along a wall would erase it.
  for (const SurfaceHit& hit : wall_between) {
    observations.mark(hit.position, Observations::occupied(1.0));
  }
  return observations;
}

/// How a row of observations is blended into the map.
struct Blending {
  explicit Blending(const MapOptions& options)
      : quality(options.quality),
        no_return_quality(options.no_return_quality),
        occupied_from(
            static_cast<int>(std::ceil(options.occupied_threshold * OccupancyGrid::kSteps)) + 1) {}

  double quality;
  double no_return_quality;
  int occupied_from;  ///< in the stored form

  [[nodiscard]] bool ceases(int before, int after) const {
    return (before >= occupied_from) & (after < occupied_from);
  }
};

/// Blends a tile's row into the map. Whether a cell of it ceased to be occupied.
MATCHBOX_SIMD_CLONES bool blend_row(const std::uint8_t* __restrict__ marks, const Blending blending,
                                    const OccupancyGrid::Stored* __restrict__ before,
                                    OccupancyGrid::Stored* __restrict__ after) {
  constexpr double kSteps = OccupancyGrid::kSteps / Observations::kOccupiedSteps;
  // In turns: with all choices in one loop the compiler makes ways through it and no vectors.
  std::array<double, kTileSize> observed;
  std::array<double, kTileSize> quality;
  std::array<int, kTileSize> blended;
  const double no_return = blending.no_return_quality;
  const double hit_or_free = blending.quality;
  for (std::size_t i = 0; i < kTileSize; ++i) {
    const int mark = marks[i];
    observed[i] = kSteps * (mark > Observations::kFree ? mark - Observations::kFree : 0);
    quality[i] = mark == Observations::kFreeNoReturn ? no_return : hit_or_free;
  }
  for (std::size_t i = 0; i < kTileSize; ++i) {
    blended[i] = OccupancyGrid::blended(before[i], observed[i], quality[i]);
  }
  int ceased = 0;
  for (std::size_t i = 0; i < kTileSize; ++i) {
    const int now = marks[i] == Observations::kUnseen ? before[i] : blended[i];
    after[i] = static_cast<OccupancyGrid::Stored>(now);
    ceased |= static_cast<int>(blending.ceases(before[i], now));
  }
  return ceased != 0;
}

/// Whether anything was seen in a tile's row.
bool is_seen(const std::uint8_t* marks) {
  unsigned any = 0;
  for (int i = 0; i < kTileSize; ++i) {
    any |= marks[i];
  }
  return any != 0;
}

/// Blends all observations into the map. Returns the cells that ceased to be occupied.
std::vector<Cell> blend(const Observations& observations, const MapOptions& options,
                        OccupancyGrid& occupancy) {
  const Blending blending(options);
  std::vector<Cell> cleared;
  const CellBox tiles = observations.tiles().tile_bounds();
  for (int ty = tiles.min.y; ty < tiles.max.y; ++ty) {
    for (int tx = tiles.min.x; tx < tiles.max.x; ++tx) {
      const Observations::Tile* tile = observations.tiles().find({tx, ty});
      if (tile == nullptr) {
        continue;
      }
      OccupancyGrid::Stored* row = occupancy.touch({tx, ty}).data();
      const std::uint8_t* marks = tile->data();
      for (int y = 0; y < kTileSize; ++y, row += kTileSize, marks += Observations::kPitch) {
        if (!is_seen(marks)) {
          continue;
        }
        std::array<OccupancyGrid::Stored, kTileSize> after;
        if (blend_row(marks, blending, row, after.data())) {
          for (int x = 0; x < kTileSize; ++x) {
            if (blending.ceases(row[x], after[static_cast<std::size_t>(x)])) {
              cleared.push_back({tx * kTileSize + x, ty * kTileSize + y});
            }
          }
        }
        std::copy(after.begin(), after.end(), row);
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
