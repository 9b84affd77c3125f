#include "slam/scan_evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

using Counts = ReflectionGrid::Counts;

constexpr std::size_t kBeams = 180;
constexpr double kWallOfWitness = 0.5;  // [m]
/// Probability that a cell that nothing is known of reflects a beam.
constexpr double kUnknownReflects = 0.02;
/// What a beam says at most. More would take it for impossible that something has moved.
constexpr double kMostOfBeam = 3.0;
/// However long, a way through free ground is one witness, and a weak one.
constexpr double kMostOfPassage = 0.3;
/// From which on a beam has gone through a wall.
constexpr double kThroughWall = 1.0;

/// Logarithms that the evidence of a cell is made of, by counts in parts of a scan. A cell reflects
/// with probability (hits + p0) / (hits + passes + 1).
class CellEvidence {
 public:
  CellEvidence() {
    for (std::size_t i = 0; i < kSize; ++i) {
      const double scans = static_cast<double>(i) / ReflectionGrid::kScan;
      hits_[i] = static_cast<float>(std::log((scans + kUnknownReflects) / kUnknownReflects));
      passes_[i] =
          static_cast<float>(std::log((scans + 1.0 - kUnknownReflects) / (1.0 - kUnknownReflects)));
      all_[i] = static_cast<float>(std::log(scans + 1.0));
    }
  }

  /// Of a beam that ends in the cell.
  [[nodiscard]] double of_end(const Counts& counts) const {
    return hits_[counts.hits] - of_both(counts);
  }
  /// Of a beam that goes on through it.
  [[nodiscard]] double of_passage(const Counts& counts) const {
    return passes_[counts.passes] - of_both(counts);
  }

 private:
  static constexpr std::size_t kSize = ReflectionGrid::kMost + 1;

  [[nodiscard]] float of_both(const Counts& counts) const {
    return all_[static_cast<std::size_t>(counts.hits + counts.passes)];
  }

  std::array<float, kSize> hits_;
  std::array<float, kSize> passes_;
  std::array<float, kSize> all_;
};

/// Reads cells one after the other, of which most lie in the tile of the one before.
class CountReader {
 public:
  explicit CountReader(const ReflectionGrid& grid) : tiles_(grid.tiles()) {}

  [[nodiscard]] Counts at(const Cell& cell) {
    const Cell tile = ReflectionGrid::Tiles::tile_of(cell);
    if (!is_begun_ || tile != position_) {
      is_begun_ = true;
      position_ = tile;
      tile_ = tiles_.find(tile);
    }
    return tile_ == nullptr ? Counts{} : (*tile_)[ReflectionGrid::Tiles::index_in_tile(cell)];
  }

 private:
  const ReflectionGrid::Tiles& tiles_;
  const ReflectionGrid::Tile* tile_ = nullptr;
  Cell position_;
  bool is_begun_ = false;
};

/// The best end near a cell, since poses and ranges are a little off.
double of_end_near(const Cell& end, const CellEvidence& cells, CountReader& counts) {
  double best = -kMostOfBeam;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      best = std::max(best, cells.of_end(counts.at({end.x + x, end.y + y})));
    }
  }
  return best;
}

/// What one beam says.
struct BeamSays {
  double log_odds = 0.0;
  bool tells_of_walls = false;
};

/// Walks along beams, from wall to wall as far as the distances of the field tell: what lies
/// between is free or unknown.
class BeamEvidence {
 public:
  BeamEvidence(const SlamMap& map, const CellEvidence& cells)
      : field_(map.field),
        geometry_(map.field.geometry()),
        metres_(map.field.options().reach / LikelihoodField::kFar),
        cells_(cells),
        counts_(map.reflection) {}

  /// @param clearance  see clearance_of
  [[nodiscard]] BeamSays of(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                            double clearance) {
    const double range = (to - from).norm();
    const Eigen::Vector2d direction = (to - from) / range;
    double free = 0.0;
    double through = 0.0;  // walls
    for (double at = 0.0; at < range - clearance && through > -2.0 * kMostOfBeam;) {
      const Cell cell = geometry_.cell_at(from + at * direction);
      const double step = std::max(metres_ * field_.distance(cell) - geometry_.resolution(),
                                   geometry_.resolution());
      const double here = cells_.of_passage(counts_.at(cell));
      free += std::max(0.0, here) * step / geometry_.resolution();
      through += std::min(0.0, here);
      at += step;
    }
    const double end = of_end_near(geometry_.cell_at(to), cells_, counts_);
    return {std::clamp(std::min(free, kMostOfPassage) + through + end, -kMostOfBeam, kMostOfBeam),
            end > 0.0 || through < -kThroughWall};
  }

  [[nodiscard]] bool is_known(const Eigen::Vector2d& place) {
    return counts_.at(geometry_.cell_at(place)).is_known();
  }

 private:
  const LikelihoodField& field_;
  GridGeometry geometry_;
  double metres_;  ///< a step of the field's distances
  const CellEvidence& cells_;
  CountReader counts_;
};

}  // namespace

ScanEvidence evidence_of(const PointScan& scan, const Pose2& map_from_base, const SlamMap& map) {
  static const CellEvidence kCells;
  const Transform2 to_map(map_from_base);
  const std::size_t stride = (scan.points.size() + kBeams - 1) / kBeams;
  BeamEvidence beam(map, kCells);
  double sum = 0.0;
  double weight = 0.0;
  double known = 0.0;
  double telling = 0.0;
  double telling_sum = 0.0;
  for (std::size_t i = stride / 2; i < scan.points.size(); i += stride) {
    const ScanPoint& point = scan.points[i];
    const Eigen::Vector2d from = to_map * point.origin;
    const Eigen::Vector2d to = to_map * point.position;
    if (!(point.weight > 0.0) || !((to - from).norm() < kFarthestPoint)) {
      continue;
    }
    weight += point.weight;
    const BeamSays says = beam.of(from, to, clearance_of(point));
    sum += point.weight * says.log_odds;
    telling += says.tells_of_walls ? point.weight : 0.0;
    telling_sum += says.tells_of_walls ? point.weight * says.log_odds : 0.0;
    known += beam.is_known(to) ? point.weight : 0.0;
  }
  if (!(weight > 0.0)) {
    return {};
  }
  const double witnesses = weight * static_cast<double>(stride) / kWallOfWitness;
  return {witnesses * sum / weight, sum / weight, known / weight, telling / weight,
          telling > 0.0 ? telling_sum / telling : 0.0};
}

}  // namespace matchbox_slam
