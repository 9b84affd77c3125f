#include "matchbox_slam/matching/free_space_violation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

// Guesses, tried on six simulated drives with faults, aces and seattle
// (benchmark/reports/current/CONSTANTS.md): half or double of the first three leaves all eight
// as they are but for one carried robot that is found nowhere either way; half of kReach makes aces
// 14 % worse, and double that and a carried robot 70 %. kBeams was not tried.
constexpr double kMinOvershoot = 0.4;  // [m] from the wall that is crossed to the end of the beam
constexpr double kMinCosine = 0.35;    // between beam and normal; below, it goes along the wall
constexpr double kMinCoherence = 0.5;  // of the double angles of hits that tell a line
constexpr double kReach = 0.15;        // [m], to each side
constexpr std::size_t kBeams = 300;

/// On the way along a beam.
struct Walk {
  std::size_t beam = 0;
  Eigen::Vector2d from, direction;
  double length = 0.0;
  double at = 0.0;
};

/// Walks along beams through a field from wall to wall, as far as the distances tell.
class BeamWalk {
 public:
  explicit BeamWalk(const LikelihoodField& field)
      : field_(field),
        resolution_(field.geometry().resolution()),
        metres_(field.metres_per_step()) {}

  [[nodiscard]] static Walk begin(std::size_t beam, const Eigen::Vector2d& from,
                                  const Eigen::Vector2d& to) {
    const double length = std::min((to - from).norm() - kMinOvershoot, kFarthestPoint);
    return {beam, from, (to - from).normalized(), length};
  }

  /// Makes a step, and says whether there is a wall, or that nothing is known yet.
  [[nodiscard]] std::optional<bool> step(Walk& walk) const {
    if (!(walk.at < walk.length)) {
      return false;
    }
    const Eigen::Vector2d here = walk.from + walk.at * walk.direction;
    const Cell cell = field_.geometry().cell_at(here);
    const double distance = metres_ * field_.distance(cell);
    if (distance <= LikelihoodField::kMaxCellsToWall * resolution_ &&
        is_within_wall(here, cell, walk.direction)) {
      return true;
    }
    walk.at += std::max(distance - resolution_, 0.5 * resolution_);
    return std::nullopt;
  }

 private:
  [[nodiscard]] bool is_on_wall(const Eigen::Vector2d& place) const {
    return metres_ * field_.distance(field_.geometry().cell_at(place)) <=
           LikelihoodField::kMaxCellsToWall * resolution_;
  }

  /// Whether a wall that the beam does not go along reaches to both sides: beams pass by the edges
  /// of things rightly, and so near that a cell cannot tell.
  [[nodiscard]] bool is_within_wall(const Eigen::Vector2d& here, const Cell& cell,
                                    const Eigen::Vector2d& direction) const {
    Surface surface;
    if (!field_.nearest_surface(cell, surface) || surface.double_angle.norm() < kMinCoherence) {
      return false;
    }
    const Eigen::Vector2d doubled = surface.double_angle.normalized();
    const Eigen::Vector2d normal(
        std::sqrt(std::max(0.0, 0.5 * (1.0 + doubled.x()))),
        std::copysign(std::sqrt(std::max(0.0, 0.5 * (1.0 - doubled.x()))), doubled.y()));
    if (std::abs(normal.dot(direction)) < kMinCosine) {
      return false;
    }
    const Eigen::Vector2d aside = kReach * Eigen::Vector2d(-normal.y(), normal.x());
    return is_on_wall(here + aside) && is_on_wall(here - aside);
  }

  const LikelihoodField& field_;
  double resolution_;
  double metres_;  ///< a step of the field's distances
};

}  // namespace

double free_space_violation(const PointScan& scan, const Pose2& map_from_base,
                            const LikelihoodField& field) {
  const BeamWalk walk(field);
  const Transform2 to_map(map_from_base);
  const std::size_t stride = (scan.points.size() + kBeams - 1) / kBeams;
  const std::size_t beams = stride > 0 ? (scan.points.size() + stride - 1) / stride : 0;
  const auto point_of = [&](std::size_t beam) -> const ScanPoint& {
    return scan.points[beam * stride];
  };
  // Several at a time, since a step has to wait for the map's memory.
  std::array<Walk, 8> walks;
  std::size_t walking = 0;
  std::array<bool, kBeams> crosses{};
  double all = 0.0;
  for (std::size_t next = 0; next < beams || walking > 0;) {
    for (; next < beams && walking < walks.size(); ++next) {
      const ScanPoint& point = point_of(next);
      const Eigen::Vector2d from = to_map * point.origin;
      const Eigen::Vector2d to = to_map * point.position;
      if (point.weight > 0.0 && from.allFinite() && to.allFinite()) {
        all += point.weight;
        walks[walking++] = BeamWalk::begin(next, from, to);
      }
    }
    for (std::size_t i = 0; i < walking;) {
      if (const std::optional<bool> found = walk.step(walks[i])) {
        crosses[walks[i].beam] = *found;
        walks[i] = walks[--walking];
      } else {
        ++i;
      }
    }
  }
  double crossing = 0.0;
  for (std::size_t beam = 0; beam < beams; ++beam) {
    crossing += crosses[beam] ? point_of(beam).weight : 0.0;
  }
  return all > 0.0 ? crossing / all : 0.0;
}

double share_on_other_sides(const PointScan& scan, const Pose2& map_from_base,
                            const LikelihoodField& field) {
  // Two cells: what is farther off lies on no wall at all.
  constexpr double kMaxWallDistance = 0.1;  // [m]
  const Transform2 to_map(map_from_base);
  const double metres = field.metres_per_step();
  double on_other_sides = 0.0;
  double all = 0.0;
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d place = to_map * point.position;
    if (!place.allFinite()) {
      continue;
    }
    all += point.weight;
    const Cell cell = field.geometry().cell_at(place);
    if (metres * field.distance(cell) <= kMaxWallDistance &&
        field.shows_other_side(cell, to_map.turned(point.normal))) {
      on_other_sides += point.weight;
    }
  }
  return all > 0.0 ? on_other_sides / all : 0.0;
}

}  // namespace matchbox_slam
