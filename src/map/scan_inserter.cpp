#include "matchbox_slam/map/scan_inserter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "common/simd.hpp"
#include "map/scan_drawing.hpp"
#include "map/scan_surfaces.hpp"
#include "map/scan_tiles.hpp"
#include "matchbox_slam/geometry/transform2.hpp"
#include "sensor/take_some.hpp"

namespace matchbox_slam {
namespace {

constexpr int kTileSize = OccupancyGrid::Tiles::kTileSize;

class Observations : public ScanTiles<std::uint8_t> {
 public:
  static constexpr std::uint8_t kUnseen = 0;
  static constexpr std::uint8_t kFreeNoReturn = 1;
  static constexpr std::uint8_t kFree = 2;
  static constexpr double kOccupiedSteps = 253.0;  // 3...255 are occupancies from just above 0 to 1

  [[nodiscard]] static std::uint8_t occupied(double occupancy) {
    return static_cast<std::uint8_t>(2 + std::lround(occupancy * kOccupiedSteps));
  }

  /// The most occupied observation of a cell wins.
  void mark(const Cell& cell, std::uint8_t value) {
    std::uint8_t& marked = touch(tile_of(cell))[static_cast<std::size_t>(position_in_tile(cell))];
    marked = std::max(marked, value);
  }

  /// Marks every cell that the segment from `a` to `b` crosses (Amanatides and Woo 1987), whatever
  /// was seen there.
  void mark_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                    const GridGeometry& geometry, std::uint8_t value);
};

void Observations::mark_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                const GridGeometry& geometry, std::uint8_t value) {
  const Cell cell = geometry.cell_at(a);
  const Cell end = geometry.cell_at(b);
  const Eigen::Vector2d way = (b - a).cwiseAbs();
  const int step_x = b.x() < a.x() ? -1 : 1;
  const int step_y = b.y() < a.y() ? -1 : 1;
  const Eigen::Vector2d from_corner = (a - geometry.corner(cell)) / geometry.resolution();
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
  Cell tile = tile_of(cell);
  int position = position_in_tile(cell);
  while (true) {
    std::uint8_t* const marks = touch(tile).data();
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
    } while (is_inside(position));
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
  void assign(double half_width, double resolution) {
    half = half_width;
    marks.clear();
    for (double offset = -half; offset < 0.5 * half; offset += 0.5 * resolution) {
      marks.emplace_back(offset, Observations::occupied(1.0 - std::abs(offset) / half));
    }
    marks.emplace_back(0.0, Observations::occupied(1.0));
  }

  double half = 0.0;                                   ///< of the width [m]
  std::vector<std::pair<double, std::uint8_t>> marks;  ///< by the way beyond the hit [m]
};

/// Cells that a scan's beams and holes lie in; none of one that says nothing.
CellBox cells_of(const PointScan& scan, const Transform2& to_map, double half_hole,
                 const GridGeometry& geometry) {
  Eigen::AlignedBox2d box;
  for (const FreeRay& ray : scan.free_rays) {
    box.extend(to_map * ray.origin);
    box.extend(to_map * ray.end);
  }
  for (const ScanPoint& point : scan.points) {
    box.extend(to_map * point.origin);
    box.extend(to_map * point.position);
  }
  if (box.isEmpty()) {
    return {};
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(half_hole + geometry.resolution());
  const Cell first = geometry.cell_at(box.min() - margin);
  const Cell last = geometry.cell_at(box.max() + margin);
  return {first, {last.x + 1, last.y + 1}};
}

/// Whether the grid with these cells in it is no larger than `max_cells`, and they lie where cells
/// are told apart.
bool has_room_for(const CellBox& cells, const OccupancyGrid& grid, double max_cells) {
  constexpr int kFarthest = (1 << 28) - (1 << 10);  // see cell_index
  if (cells.empty()) {
    return true;
  }
  CellBox all = cells;
  if (const CellBox tiles = grid.tiles().tile_bounds(); !tiles.empty()) {
    all.include({tiles.min.x * kTileSize, tiles.min.y * kTileSize});
    all.include({tiles.max.x * kTileSize - 1, tiles.max.y * kTileSize - 1});
  }
  // A map as thin as a line has few cells, and yet its tiles.
  return std::min(cells.min.x, cells.min.y) > -kFarthest &&
         std::max(cells.max.x, cells.max.y) < kFarthest &&
         (all.width() + double{kTileSize}) * (all.height() + double{kTileSize}) <= max_cells;
}

void observe(const PointScan& scan, const std::vector<SurfaceHit>& wall_between,
             const Transform2& to_map, const MapOptions& options, MapUse use, const Hole& hole,
             Observations& observations) {
  const GridGeometry geometry(options.resolution);
  for (const FreeRay& ray : scan.free_rays) {
    observations.mark_segment(to_map * ray.origin, to_map * ray.end, geometry,
                              Observations::kFreeNoReturn);
  }
  // What is more occupied comes later.
  const std::size_t most =
      use == MapUse::kMatched ? kPassingBeams : std::max<std::size_t>(1, scan.points.size());
  take_some(scan, most, [&](const ScanPoint& point) {
    const Eigen::Vector2d origin = to_map * point.origin;
    const Eigen::Vector2d way = to_map * point.position - origin;
    const double range = way.norm();
    if (range > hole.half) {
      observations.mark_segment(origin, origin + (range - hole.half) * (way / range), geometry,
                                Observations::kFree);
    }
  });
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d hit = to_map * point.position;
    const Eigen::Vector2d way = hit - to_map * point.origin;
    const double range = way.norm();
    const Eigen::Vector2d direction = way / std::max(range, 1e-9);
    for (const auto& [offset, value] : hole.marks) {
      if (offset >= -range) {
        observations.mark(geometry.cell_at(hit + offset * direction), value);
      }
    }
  }
  // Far away the beams are wider apart than cells, and those grazing along a wall would erase it.
  for (const SurfaceHit& hit : wall_between) {
    observations.mark(geometry.cell_at(hit.position), Observations::occupied(1.0));
  }
}

/// Whether anything was seen in a tile's row.
bool is_seen(const std::uint8_t* marks) {
  unsigned any = 0;
  for (int i = 0; i < kTileSize; ++i) {
    any |= marks[i];
  }
  return any != 0;
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

/// Blends all observations into the map, and forgets them.
/// @param cleared  gets the cells that ceased to be occupied.
void blend(Observations& observations, const MapOptions& options, OccupancyGrid& occupancy,
           std::vector<Cell>& cleared) {
  const Blending blending(options);
  cleared.clear();
  observations.take_tiles([&](const Cell& tile, Observations::Tile& seen) {
    std::uint8_t* marks = seen.data();
    OccupancyGrid::Stored* row = occupancy.touch(tile).data();
    for (int y = 0; y < kTileSize; ++y, marks += Observations::kPitch, row += kTileSize) {
      if (!is_seen(marks)) {
        continue;
      }
      std::array<OccupancyGrid::Stored, kTileSize> after;
      if (blend_row(marks, blending, row, after.data())) {
        for (int x = 0; x < kTileSize; ++x) {
          if (blending.ceases(row[x], after[static_cast<std::size_t>(x)])) {
            cleared.push_back({tile.x * kTileSize + x, tile.y * kTileSize + y});
          }
        }
      }
      std::copy(after.begin(), after.end(), row);
      std::fill_n(marks, kTileSize, Observations::kUnseen);
    }
  });
}

}  // namespace

struct InsertionMemory::Parts {
  Observations observations;
  Hole hole;
  // What a scan changes in the likelihood field.
  std::vector<SurfaceHit> hits;
  std::vector<Cell> cleared;
};

InsertionMemory::InsertionMemory() = default;
InsertionMemory::InsertionMemory(const InsertionMemory& /*other*/) {}
InsertionMemory::InsertionMemory(InsertionMemory&& other) noexcept = default;
InsertionMemory& InsertionMemory::operator=(const InsertionMemory& /*other*/) { return *this; }
InsertionMemory& InsertionMemory::operator=(InsertionMemory&& other) noexcept = default;
InsertionMemory::~InsertionMemory() = default;

InsertionMemory::Parts& InsertionMemory::parts() {
  if (parts_ == nullptr) {
    parts_ = std::make_unique<Parts>();
  }
  return *parts_;
}

namespace {

/// Draws all but the field and the reflections.
/// @returns what that changes in the field; null where nothing can be drawn.
const InsertionMemory::Parts* draw(const PointScan& scan, const Pose2& map_from_base,
                                   const MapOptions& options, MapUse use, SlamMap& map) {
  if (!draw_occupancy(scan, map_from_base, options, use, map.insertion, map.occupancy)) {
    return nullptr;
  }
  InsertionMemory::Parts& parts = map.insertion.parts();
  std::vector<SurfaceHit>& hits = parts.hits;
  add_surfaces_at_hits(scan, map_from_base, hits);
  const auto is_free = [&](const SurfaceHit& hit) {
    return map.occupancy.occupancy(map.occupancy.geometry().cell_at(hit.position)) <
           options.occupied_threshold;
  };
  hits.erase(std::remove_if(hits.begin(), hits.end(), is_free), hits.end());
  return &parts;
}

}  // namespace

bool has_room(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
              const SlamMap& map) {
  const CellBox cells = cells_of(scan, Transform2(map_from_base), 0.0, map.occupancy.geometry());
  return has_room_for(cells, map.occupancy, options.max_cells);
}

bool draw_occupancy(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                    MapUse use, InsertionMemory& memory, OccupancyGrid& occupancy) {
  const Transform2 to_map(map_from_base);
  InsertionMemory::Parts& parts = memory.parts();
  parts.hole.assign(0.5 * options.hole_width, options.resolution);
  const CellBox cells = cells_of(scan, to_map, parts.hole.half, GridGeometry(options.resolution));
  // Whoever allows fewer cells is told so of scans that come, not of key scans that are drawn
  // again.
  if (!has_room_for(cells, occupancy, std::max(options.max_cells, MapOptions{}.max_cells))) {
    return false;
  }
  parts.hits.clear();
  add_surfaces_between_hits(scan, map_from_base, options.resolution, parts.hits);
  parts.observations.assign(cells.empty() ? CellBox{{0, 0}, {1, 1}} : cells);
  observe(scan, parts.hits, to_map, options, use, parts.hole, parts.observations);
  blend(parts.observations, options, occupancy, parts.cleared);
  return true;
}

void insert_scan(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                 SlamMap& map) {
  if (const auto* change = draw(scan, map_from_base, options, MapUse::kShown, map)) {
    map.reflection.count(scan, map_from_base);
    map.field.update(change->hits, change->cleared);
  }
}

void insert_unrendered(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                       MapUse use, SlamMap& map) {
  if (const auto* change = draw(scan, map_from_base, options, use, map)) {
    map.reflection.count(scan, map_from_base);
    map.field.take(change->hits, change->cleared);
  }
}

}  // namespace matchbox_slam
