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
#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

using Counts = ReflectionGrid::Counts;

constexpr std::size_t kBeams = 360;  // of a scan, that are counted
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

bool is_any_known(const Counts* row) {
  static const std::array<Counts, kRow> kBlank{};
  return std::memcmp(row, kBlank.data(), sizeof(kBlank)) != 0;
}

using Half = std::int16_t;  // as many of them as can be worked on at once
using Row = std::array<Half, kRow>;

Half one_if(bool is_so) { return static_cast<Half>(is_so); }

/// What a tile's row counts after a scan of which these beams were seen in it. Quotients are
/// counted out, since there are no vectors of divisions.
MATCHBOX_SIMD_CLONES void take_row(const Counts* __restrict__ seen, Counts* __restrict__ counts) {
  constexpr Half kScan = ReflectionGrid::kScan;
  constexpr Half kMost = ReflectionGrid::kMost;
  // Both counts of a cell as one number: bytes apart would be gathered one by one.
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ && sizeof(Counts) == 2);
  std::array<std::uint16_t, kRow> both_seen;
  std::array<std::uint16_t, kRow> both;
  std::memcpy(both_seen.data(), seen, sizeof(both_seen));
  std::memcpy(both.data(), counts, sizeof(both));
  Row hits;  // of the scan, in its parts
  for (std::size_t i = 0; i < kRow; ++i) {
    const auto seen_hits = static_cast<Half>(both_seen[i] & 255);
    const auto beams = static_cast<Half>(seen_hits + (both_seen[i] >> 8));
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
    // grown * kMost / all, rounded
    const auto more = static_cast<Half>(grown * static_cast<Half>(all - kMost) - (all >> 1));
    const auto kept =
        static_cast<Half>(grown - one_if(more > 0) - one_if(more > all) - one_if(more > twice) -
                          one_if(more > static_cast<Half>(twice + all)));
    // Where rounding would keep a few old hits, or passes, for ever one makes room.
    const Half keeps_hits = one_if((hits[i] == 0) & (kept > 0) & (kept == old_hits));
    const Half keeps_passes = one_if((hits[i] == kScan) & (kept < kMost) &
                                     (static_cast<Half>(kMost - kept) == old_passes));
    const auto shrunk = static_cast<Half>(kept + keeps_passes - keeps_hits);
    new_hits[i] = all > kMost ? shrunk : grown;
    new_passes[i] = static_cast<Half>((all > kMost ? kMost : all) - new_hits[i]);
  }
  for (std::size_t i = 0; i < kRow; ++i) {
    const auto now = static_cast<std::uint16_t>(new_hits[i] | (new_passes[i] << 8));
    both[i] = both_seen[i] != 0 ? now : both[i];
  }
  std::memcpy(static_cast<void*>(counts), both.data(), sizeof(both));
}

}  // namespace

double clearance_of(const ScanPoint& point) {
  constexpr double kBeforeSurface = 0.08;  // [m], perpendicular to it: a cell and the ranges' noise
  constexpr double kLeast = 0.1;           // [m] along the beam
  constexpr double kMost = 1.0;
  const Eigen::Vector2d way = point.position - point.origin;
  const double facing = std::abs(way.normalized().dot(point.normal));
  return facing > 0.0 ? std::clamp(kBeforeSurface / facing, kLeast, kMost) : 0.3;
}

/// Beams of one scan by cell, in tiles that are used again.
class ReflectionGrid::Tally {
 public:
  /// Nothing was seen yet.
  /// @param cells  where all that will be counted lies.
  void begin(const CellBox& cells) {
    const Cell last = Tiles::tile_of({cells.max.x - 1, cells.max.y - 1});
    box_ = {Tiles::tile_of(cells.min), {last.x + 1, last.y + 1}};
    slots_.assign(static_cast<std::size_t>(box_.width()) * static_cast<std::size_t>(box_.height()),
                  nullptr);
    used_ = 0;
    current_ = nullptr;
  }

  Counts& at(const Cell& cell) {
    const bool is_inside = ((cell.x ^ inside_.x) | (cell.y ^ inside_.y)) >> Tiles::kTileBits == 0;
    if (!is_inside || current_ == nullptr) {
      current_ = &touch(Tiles::tile_of(cell));
      inside_ = cell;
    }
    return (*current_)[Tiles::index_in_tile(cell)];
  }

  /// Calls take(tile, counts) for each tile of which something was seen, and forgets it.
  template <typename Take>
  void take_tiles(Take&& take) {
    std::size_t slot = 0;
    for (int y = box_.min.y; y < box_.max.y; ++y) {
      for (int x = box_.min.x; x < box_.max.x; ++x, ++slot) {
        if (slots_[slot] != nullptr) {
          take(Cell{x, y}, *slots_[slot]);
        }
      }
    }
  }

 private:
  Tile& touch(const Cell& tile) {
    Tile*& slot = slots_[static_cast<std::size_t>(tile.y - box_.min.y) *
                             static_cast<std::size_t>(box_.width()) +
                         static_cast<std::size_t>(tile.x - box_.min.x)];
    if (slot == nullptr) {
      if (used_ == tiles_.size()) {
        tiles_.push_back(std::make_unique<Tile>());
      }
      slot = tiles_[used_++].get();
    }
    return *slot;
  }

  CellBox box_;                               ///< in tiles
  std::vector<Tile*> slots_;                  ///< row by row; null where nothing was seen
  std::vector<std::unique_ptr<Tile>> tiles_;  ///< from `used_` on blank
  std::size_t used_ = 0;
  Tile* current_ = nullptr;  // consecutive cells of a beam mostly share their tile
  Cell inside_;              // a cell of it
};

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
  tally_->begin(cells);
  const auto add = [](std::uint8_t& count) {
    count = static_cast<std::uint8_t>(count + (count < 255 ? 1 : 0));
  };
  // Beams side by side say the same: a thousand of them would take as long as all else together.
  const std::size_t stride = (scan.points.size() + kBeams - 1) / kBeams;
  for (std::size_t i = 0; i < scan.points.size(); i += stride) {
    const ScanPoint& point = scan.points[i];
    const Passage passage = passage_of(point, to_map);
    walk_cells(geometry_.cell_at(passage.from), geometry_.cell_at(passage.to),
               [&](const Cell& cell) { add(tally_->at(cell).passes); });
  }
  for (std::size_t i = 0; i < scan.points.size(); i += stride) {
    add(tally_->at(geometry_.cell_at(to_map * scan.points[i].position)).hits);
  }
  tally_->take_tiles([this](const Cell& tile, Tile& seen) { take(tile, seen); });
}

void ReflectionGrid::count(const OccupancyGrid& occupancy) {
  constexpr int kScans = 8;
  constexpr double kWall = 0.5;
  constexpr auto kSeen = static_cast<std::uint8_t>(kScans * kScan);
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
          counts[i] = is_wall ? Counts{kSeen, 0} : Counts{0, kSeen};
        }
      }
    }
  }
}

void ReflectionGrid::take(const Cell& tile, Tile& seen) {
  static const Tile kBlank{};
  Counts* counts = tiles_.touch(tile, kBlank).data();
  for (Counts* row = seen.data(); row != seen.data() + seen.size(); row += kRow, counts += kRow) {
    if (is_any_known(row)) {
      take_row(row, counts);
      std::fill_n(row, kRow, Counts{});
    }
  }
}

}  // namespace matchbox_slam
