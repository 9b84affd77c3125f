#include "matchbox_slam/map/reflection_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "common/simd.hpp"
#include "map/scan_drawing.hpp"
#include "map/scan_tiles.hpp"
#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

using Counts = ReflectionGrid::Counts;

constexpr std::size_t kRow = ReflectionGrid::Tiles::kTileSize;

/// Where a beam counts as passing.
struct Passage {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

Passage passage_of(const ScanPoint& point, const Transform2& to_map) {
  const Eigen::Vector2d from = to_map * point.origin;
  const Eigen::Vector2d way = to_map * point.position - from;
  const double range = way.norm();
  const double share = range > 0.0 ? std::max(0.0, 1.0 - clearance_of(point) / range) : 0.0;
  return {from, from + share * way};
}

/// Beams of a scan in a tile's row: how many passed each cell, then how many ended there.
using SeenRow = std::array<std::uint16_t, 2 * kRow>;

bool is_any_seen(const std::uint16_t* row) {
  static const SeenRow kBlank{};
  return std::memcmp(row, kBlank.data(), sizeof(kBlank)) != 0;
}

using Half = std::int16_t;  // as many of them as can be worked on at once
using Row = std::array<Half, kRow>;

Half one_if(bool is_so) { return static_cast<Half>(is_so); }

/// What a tile's row counts after a scan of which these beams were seen in it. Quotients are
/// counted out, since there are no vectors of divisions.
MATCHBOX_SIMD_CLONES void take_row(const std::uint16_t* __restrict__ seen,
                                   Counts* __restrict__ counts) {
  constexpr std::uint16_t kMostSeen = 255;
  constexpr Half kScan = ReflectionGrid::kScan;
  constexpr Half kMaxCount = ReflectionGrid::kMaxCount;
  // Both counts of a cell as one number: bytes apart would be gathered one by one.
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ && sizeof(Counts) == 2);
  std::array<std::uint16_t, kRow> both;
  std::memcpy(both.data(), counts, sizeof(both));
  Row hits;  // of the scan, in its parts
  for (std::size_t i = 0; i < kRow; ++i) {
    const auto seen_hits = static_cast<Half>(std::min(seen[kRow + i], kMostSeen));
    const auto beams = static_cast<Half>(seen_hits + std::min(seen[i], kMostSeen));
    const auto twice = static_cast<Half>(2 * beams);
    const auto parts = static_cast<Half>(kScan * seen_hits + (beams >> 1));
    hits[i] = static_cast<Half>(one_if(parts >= beams) + one_if(parts >= twice) +
                                one_if(parts >= static_cast<Half>(twice + beams)) +
                                one_if(parts >= static_cast<Half>(2 * twice)));
  }
  Row new_hits;
  Row new_passes;
  for (std::size_t i = 0; i < kRow; ++i) {
    const auto old_hits = static_cast<Half>(both[i] & 255);
    const auto old_passes = static_cast<Half>(both[i] >> 8);
    const auto grown = static_cast<Half>(old_hits + hits[i]);
    const auto all = static_cast<Half>(old_hits + old_passes + kScan);
    const auto twice = static_cast<Half>(2 * all);
    // grown * kMaxCount / all, rounded
    const auto more = static_cast<Half>(grown * static_cast<Half>(all - kMaxCount) - (all >> 1));
    const auto kept =
        static_cast<Half>(grown - one_if(more > 0) - one_if(more > all) - one_if(more > twice) -
                          one_if(more > static_cast<Half>(twice + all)));
    // Where rounding would keep a few old hits, or passes, for ever one makes room.
    const Half keeps_hits = one_if((hits[i] == 0) & (kept > 0) & (kept == old_hits));
    const Half keeps_passes = one_if((hits[i] == kScan) & (kept < kMaxCount) &
                                     (static_cast<Half>(kMaxCount - kept) == old_passes));
    const auto shrunk = static_cast<Half>(kept + keeps_passes - keeps_hits);
    new_hits[i] = all > kMaxCount ? shrunk : grown;
    new_passes[i] = static_cast<Half>((all > kMaxCount ? kMaxCount : all) - new_hits[i]);
  }
  for (std::size_t i = 0; i < kRow; ++i) {
    const auto now = static_cast<std::uint16_t>(new_hits[i] | (new_passes[i] << 8));
    both[i] = (seen[i] | seen[kRow + i]) != 0 ? now : both[i];
  }
  std::memcpy(static_cast<void*>(counts), both.data(), sizeof(both));
}

/// Takes what a scan saw of a tile, which is blank then.
void take_tile(std::uint16_t* seen, Counts* counts) {
  for (std::size_t y = 0; y < kRow; ++y, seen += 2 * kRow, counts += kRow) {
    if (is_any_seen(seen)) {
      take_row(seen, counts);
      std::fill_n(seen, 2 * kRow, std::uint16_t{0});
    }
  }
}

}  // namespace

double clearance_of(const ScanPoint& point) {
  constexpr double kSurfaceMargin = 0.08;  // [m], perpendicular to it: a cell and the ranges' noise
  constexpr double kMinClearance = 0.1;    // [m] along the beam
  constexpr double kMaxClearance = 1.0;
  const Eigen::Vector2d way = point.position - point.origin;
  const double facing = std::abs(way.normalized().dot(point.normal));
  return facing > 0.0 ? std::clamp(kSurfaceMargin / facing, kMinClearance, kMaxClearance) : 0.3;
}

/// Beams of one scan by cell.
class ReflectionGrid::Tally : public ScanTiles<std::uint16_t> {
 public:
  /// Counted beside those that pass, where a row has room.
  void end_in(const Cell& cell) {
    const auto position = static_cast<std::size_t>(position_in_tile(cell));
    ++touch(tile_of(cell))[position + kTileSize];
  }

  /// The cells of a segment, without its last one: Bresenham's walk in integers, which steps along
  /// the longer side.
  void pass(const Cell& from, const Cell& to);
};

void ReflectionGrid::Tally::pass(const Cell& from, const Cell& to) {
  const int width = std::abs(to.x - from.x);
  const int height = std::abs(to.y - from.y);
  const bool is_flat = width >= height;
  const int longer = is_flat ? width : height;
  const int shorter = is_flat ? height : width;
  const int along_x = to.x < from.x ? -1 : 1;
  const int along_y = to.y < from.y ? -kPitch : kPitch;
  const int along = is_flat ? along_x : along_y;
  const int aside = is_flat ? along_y : along_x;
  int off = longer - 2 * shorter;  // below 0 the next step goes aside, too
  Cell tile = tile_of(from);
  int position = position_in_tile(from);
  for (int left = longer; left > 0;) {
    std::uint16_t* const cells = touch(tile).data();
    do {
      ++cells[position];
      const int goes_aside = off >> 31;  // all bits set, or none
      off += (goes_aside & (2 * longer)) - 2 * shorter;
      position += along + (goes_aside & aside);
    } while (--left > 0 && is_inside(position));
    // Counted from one row and one column before the tile.
    const int from_before = position + kPitch + 1;
    const Cell cell{from_before % kPitch - 1, from_before / kPitch - 1};
    tile = {tile.x + tile_of(cell).x, tile.y + tile_of(cell).y};
    position = position_in_tile(cell);
  }
}

ReflectionGrid::ReflectionGrid(double resolution) : geometry_(resolution) {}
ReflectionGrid::ReflectionGrid(const ReflectionGrid& other)
    : geometry_(other.geometry_), tiles_(other.tiles_) {}
ReflectionGrid::ReflectionGrid(ReflectionGrid&& other) noexcept = default;
ReflectionGrid& ReflectionGrid::operator=(const ReflectionGrid& other) {
  geometry_ = other.geometry_;
  tiles_ = other.tiles_;
  return *this;
}
ReflectionGrid& ReflectionGrid::operator=(ReflectionGrid&& other) noexcept = default;
ReflectionGrid::~ReflectionGrid() = default;

void ReflectionGrid::count(const PointScan& scan, const Pose2& map_from_base) {
  const Transform2 to_map(map_from_base);
  CellBox cells;
  for (const ScanPoint& point : scan.points) {
    cells.include(geometry_.cell_at(to_map * point.origin));
    cells.include(geometry_.cell_at(to_map * point.position));
  }
  // Wild points would take all memory.
  const double far = kFarthestPoint / geometry_.resolution();
  if (cells.empty() || cells.width() > 4.0 * far || cells.height() > 4.0 * far) {
    return;
  }
  if (tally_ == nullptr) {
    tally_ = std::make_unique<Tally>();
  }
  tally_->assign(cells);
  const std::size_t stride = (scan.points.size() + kPassingBeams - 1) / kPassingBeams;
  for (std::size_t i = 0; i < scan.points.size(); i += stride) {
    const ScanPoint& point = scan.points[i];
    const Passage passage = passage_of(point, to_map);
    tally_->pass(geometry_.cell_at(passage.from), geometry_.cell_at(passage.to));
    tally_->end_in(geometry_.cell_at(to_map * point.position));
  }
  static const Tile kBlank{};
  tally_->take_tiles([this](const Cell& tile, Tally::Tile& seen) {
    take_tile(seen.data(), tiles_.touch(tile, kBlank).data());
  });
}

void ReflectionGrid::count(const OccupancyGrid& occupancy) {
  constexpr int kScans = 8;
  constexpr double kWall = 0.5;
  constexpr auto kImportedCount = static_cast<std::uint8_t>(kScans * kScan);
  const CellBox tiles = occupancy.tiles().tile_bounds();
  for (int y = tiles.min.y; y < tiles.max.y; ++y) {
    for (int x = tiles.min.x; x < tiles.max.x; ++x) {
      const OccupancyGrid::Tile* seen = occupancy.tiles().find({x, y});
      if (seen == nullptr) {
        continue;
      }
      Tile& counts = tiles_.touch({x, y}, Tile{});
      for (std::size_t i = 0; i < seen->size(); ++i) {
        if ((*seen)[i] != OccupancyGrid::kUnknown) {
          const bool is_wall = OccupancyGrid::to_probability((*seen)[i]) > kWall;
          counts[i] = is_wall ? Counts{kImportedCount, 0} : Counts{0, kImportedCount};
        }
      }
    }
  }
}

}  // namespace matchbox_slam
