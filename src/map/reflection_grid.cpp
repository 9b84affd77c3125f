#include "matchbox_slam/map/reflection_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kBeams = 360;  // of a scan, that are counted

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
  }

  Counts& at(const Cell& cell) {
    const Cell tile = Tiles::tile_of(cell);
    Tile*& slot = slots_[static_cast<std::size_t>(tile.y - box_.min.y) *
                             static_cast<std::size_t>(box_.width()) +
                         static_cast<std::size_t>(tile.x - box_.min.x)];
    if (slot == nullptr) {
      if (used_ == tiles_.size()) {
        tiles_.push_back(std::make_unique<Tile>());
      }
      slot = tiles_[used_++].get();
      slot->fill({});
    }
    return (*slot)[Tiles::index_in_tile(cell)];
  }

  /// Calls take(tile, counts) for each tile of which something was seen.
  template <typename Take>
  void for_each_tile(Take&& take) const {
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
  CellBox box_;               ///< in tiles
  std::vector<Tile*> slots_;  ///< row by row; null where nothing was seen
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::size_t used_ = 0;
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
  tally_->for_each_tile([this](const Cell& tile, const Tile& seen) { take(tile, seen); });
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

void ReflectionGrid::take(const Cell& tile, const Tile& seen) {
  static const Tile kBlank{};
  Tile& counts = tiles_.touch(tile, kBlank);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i].is_known()) {
      continue;
    }
    const int beams = seen[i].hits + seen[i].passes;
    const int hits = (kScan * seen[i].hits + beams / 2) / beams;
    int all_hits = counts[i].hits + hits;
    int all_passes = counts[i].passes + kScan - hits;
    if (const int all = all_hits + all_passes; all > kMost) {
      all_hits = (all_hits * kMost + all / 2) / all;
      // Where rounding would keep a few old hits, or passes, for ever one makes room.
      const bool keeps_hits = hits == 0 && all_hits > 0 && all_hits == counts[i].hits;
      const bool keeps_passes =
          hits == kScan && all_hits < kMost && kMost - all_hits == counts[i].passes;
      all_hits += (keeps_passes ? 1 : 0) - (keeps_hits ? 1 : 0);
      all_passes = kMost - all_hits;
    }
    counts[i] = {static_cast<std::uint8_t>(all_hits), static_cast<std::uint8_t>(all_passes)};
  }
}

}  // namespace matchbox_slam
