#include "slam/scan_evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "matchbox_slam/geometry/transform2.hpp"
#include "sensor/take_some.hpp"

namespace matchbox_slam {
namespace {

using Counts = ReflectionGrid::Counts;

constexpr double kWallOfWitness = 0.5;  // [m]
/// Probability that a cell that nothing is known of reflects a beam.
constexpr double kUnknownReflectance = 0.02;
/// What a beam says at most, and what all says against it that it crosses: a pane of glass is one
/// wall, however many cells. More would take it for impossible that something has moved.
constexpr double kMostOfBeam = 3.0;
/// However long, a way through free ground is one witness, and a weak one.
constexpr double kMostOfPassage = 0.3;
/// From which on a beam has gone through a wall.
constexpr double kMinWallEvidence = 1.0;

/// Logarithms that the evidence of a cell is made of, by counts in parts of a scan. A cell reflects
/// with probability (hits + p0) / (hits + passes + 1).
class CellEvidence {
 public:
  CellEvidence() {
    for (std::size_t i = 0; i < kSize; ++i) {
      const double scans = static_cast<double>(i) / ReflectionGrid::kScan;
      hits_[i] = static_cast<float>(std::log((scans + kUnknownReflectance) / kUnknownReflectance));
      passes_[i] = static_cast<float>(
          std::log((scans + 1.0 - kUnknownReflectance) / (1.0 - kUnknownReflectance)));
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
  static constexpr std::size_t kSize = ReflectionGrid::kMaxCount + 1;

  [[nodiscard]] float of_both(const Counts& counts) const {
    return all_[static_cast<std::size_t>(counts.hits + counts.passes)];
  }

  std::array<float, kSize> hits_;
  std::array<float, kSize> passes_;
  std::array<float, kSize> all_;
};

/// Reads cells one after the other, of which most lie in the tile of the one before.
class GroundReader {
 public:
  explicit GroundReader(const SlamMap& map) : reflection_(map.reflection), field_(map.field) {
    enter(inside_);
  }

  [[nodiscard]] Counts counts(const Cell& cell) {
    go_to(cell);
    return counts_ == nullptr ? Counts{} : (*counts_)[Tiles::index_in_tile(cell)];
  }

  /// As of the field.
  [[nodiscard]] std::uint8_t distance(const Cell& cell) {
    go_to(cell);
    return distances_ == nullptr ? LikelihoodField::kFar
                                 : distances_->distance[Tiles::index_in_tile(cell)];
  }

 private:
  using Tiles = ReflectionGrid::Tiles;
  static_assert(LikelihoodField::Tiles::kTileBits == Tiles::kTileBits);

  void go_to(const Cell& cell) {
    if (((cell.x ^ inside_.x) | (cell.y ^ inside_.y)) >> Tiles::kTileBits != 0) {
      enter(cell);
    }
  }

  void enter(const Cell& cell) {
    inside_ = cell;
    counts_ = reflection_.tiles().find(Tiles::tile_of(cell));
    distances_ = field_.tiles().find(Tiles::tile_of(cell));
  }

  const ReflectionGrid& reflection_;
  const LikelihoodField& field_;
  Cell inside_;  ///< a cell of the tiles
  const ReflectionGrid::Tile* counts_ = nullptr;
  const LikelihoodField::Tile* distances_ = nullptr;
};

/// The best end near a cell, since poses and ranges are a little off.
double of_end_near(const Cell& end, const CellEvidence& cells, GroundReader& ground) {
  double best = -kMostOfBeam;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      best = std::max(best, cells.of_end(ground.counts({end.x + x, end.y + y})));
    }
  }
  return best;
}

/// What one beam says.
struct BeamSays {
  double log_odds = 0.0;
  bool tells_of_walls = false;
  bool ends_on_known = false;
};

/// Walks along a beam, from wall to wall as far as the distances of the field tell: what lies
/// between is free or unknown.
class BeamWalk {
 public:
  explicit BeamWalk(const SlamMap& map)
      : field_(map.field),
        geometry_(map.field.geometry()),
        metres_(map.field.metres_per_step()),
        ground_(map) {}

  /// @param clearance  see clearance_of
  void begin(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double clearance) {
    const double range = (to - from).norm();
    from_ = from;
    to_ = to;
    direction_ = (to - from) / range;
    end_ = range - clearance;
    at_ = 0.0;
    free_ = 0.0;
    through_ = 0.0;
  }

  /// Whether it was not yet at its end.
  bool step(const CellEvidence& cells) {
    if (!(at_ < end_ && through_ > -kMostOfBeam)) {
      return false;
    }
    const Cell cell = geometry_.cell_at(from_ + at_ * direction_);
    const double step =
        std::max(metres_ * ground_.distance(cell) - geometry_.resolution(), geometry_.resolution());
    const double here = cells.of_passage(ground_.counts(cell));
    free_ += std::max(0.0, here) * step / geometry_.resolution();
    through_ += std::min(0.0, here);
    at_ += step;
    return true;
  }

  /// When it is at its end.
  [[nodiscard]] BeamSays says(const Eigen::Vector2d& normal, const CellEvidence& cells) {
    const Cell last = geometry_.cell_at(to_);
    double end = of_end_near(last, cells, ground_);
    bool ends_on_known = ground_.counts(last).is_known();
    if (end > 0.0 && field_.shows_other_side(last, normal)) {  // of which nothing is known
      end = 0.0;
      ends_on_known = false;
    }
    const double way = std::min(free_, kMostOfPassage) + std::max(through_, -kMostOfBeam);
    return {std::clamp(way + end, -kMostOfBeam, kMostOfBeam),
            end > 0.0 || through_ < -kMinWallEvidence, ends_on_known};
  }

 private:
  const LikelihoodField& field_;
  GridGeometry geometry_;
  double metres_;  ///< a step of the field's distances
  GroundReader ground_;
  Eigen::Vector2d from_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction_ = Eigen::Vector2d::Zero();
  double end_ = 0.0;  ///< [m] from where it begins, as the next
  double at_ = 0.0;
  double free_ = 0.0;
  double through_ = 0.0;  ///< walls
};

/// Beams of a scan that say something, spread evenly, and the length of wall that each stands for
/// [m]: to the middle of the way to its neighbours, up to what makes a witness.
class EvenBeams {
 public:
  EvenBeams(const PointScan& scan, const Transform2& to_map) {
    take_some(scan, kEvidenceBeams, [&](const ScanPoint& point) {
      const double range = (to_map * point.position - to_map * point.origin).norm();
      if (point.weight > 0.0 && range < kFarthestPoint) {
        beams_[count_++] = &point;
      }
    });
  }

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] const ScanPoint& operator[](std::size_t i) const { return *beams_[i]; }
  [[nodiscard]] double length(std::size_t i) const {
    constexpr double kMinLength = 1e-3;
    return std::max(kMinLength, 0.5 * (gap_after(i) + (i > 0 ? gap_after(i - 1) : 0.0)));
  }

 private:
  [[nodiscard]] double gap_after(std::size_t i) const {
    return i + 1 < count_
               ? std::min(kWallOfWitness, (beams_[i + 1]->position - beams_[i]->position).norm())
               : 0.0;
  }

  std::array<const ScanPoint*, kEvidenceBeams> beams_{};
  std::size_t count_ = 0;
};

}  // namespace

ScanEvidence evidence_of(const PointScan& scan, const Pose2& map_from_base, const SlamMap& map) {
  static const CellEvidence kCells;
  const Transform2 to_map(map_from_base);
  const EvenBeams beams(scan, to_map);
  // Side by side, since each step waits for the one before it, and not for those of other beams.
  std::array<BeamWalk, 4> walks{BeamWalk(map), BeamWalk(map), BeamWalk(map), BeamWalk(map)};
  double log_odds = 0.0;
  double all = 0.0;  // of weights
  double sum = 0.0;
  double known = 0.0;
  double telling = 0.0;
  double telling_witnesses = 0.0;
  double telling_sum = 0.0;
  for (std::size_t first = 0; first < beams.size(); first += walks.size()) {
    const std::size_t count = std::min(walks.size(), beams.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      const ScanPoint& point = beams[first + k];
      walks[k].begin(to_map * point.origin, to_map * point.position, clearance_of(point));
    }
    for (bool goes_on = true; goes_on;) {
      goes_on = false;
      for (std::size_t k = 0; k < count; ++k) {
        goes_on = walks[k].step(kCells) || goes_on;
      }
    }
    for (std::size_t k = 0; k < count; ++k) {
      const ScanPoint& point = beams[first + k];
      const BeamSays says = walks[k].says(to_map.turned(point.normal), kCells);
      const double witnesses = known_share(point) * beams.length(first + k) / kWallOfWitness;
      log_odds += witnesses * says.log_odds;
      all += point.weight;
      sum += point.weight * says.log_odds;
      telling += says.tells_of_walls ? point.weight : 0.0;
      telling_witnesses += says.tells_of_walls ? witnesses : 0.0;
      telling_sum += says.tells_of_walls ? witnesses * says.log_odds : 0.0;
      known += says.ends_on_known ? point.weight : 0.0;
    }
  }
  if (!(all > 0.0)) {
    return {};
  }
  const double telling_mean = telling_witnesses > 0.0 ? telling_sum / telling_witnesses : 0.0;
  return {log_odds, sum / all, known / all, telling / all, telling_witnesses, telling_mean};
}

double odds_of_elsewhere(const ScanEvidence& evidence) {
  constexpr double kAgreementMean = 2.0;
  constexpr double kMostContradiction = 9.0;  // below kPriorAgainstCarried: one is not enough
  constexpr double kWholeScan = 4.0;          // witnesses
  const double share = std::min(1.0, evidence.telling_witnesses / kWholeScan);
  const double missing = kAgreementMean - evidence.telling_mean;
  return share * (missing > 0.0 ? std::min(missing * missing, kMostContradiction) : -1.0);
}

bool is_badly_explained(const ScanEvidence& evidence) {
  constexpr double kLeastMean = 1.0;  // of a beam on known ground; right poses have 3 mostly
  return evidence.mean < std::max(0.0, kLeastMean * evidence.known);
}

}  // namespace matchbox_slam
