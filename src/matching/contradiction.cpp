#include "matchbox_slam/matching/contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

constexpr double kClearly = 0.4;  // [m] from the wall that is crossed to the end of the beam
constexpr double kAlong = 0.35;   // cosine between beam and normal; below, it goes along the wall
constexpr double kLine = 0.5;     // length of the mean double angle from which hits tell a line
constexpr double kReach = 0.15;   // [m], to each side
constexpr double kFarthest = 100.0;  // [m]; no laser sees farther, and a wild reading takes no time
constexpr std::size_t kBeams = 300;

/// Walks along beams through a field from wall to wall, as far as the distances tell.
class BeamWalk {
 public:
  explicit BeamWalk(const LikelihoodField& field)
      : field_(field),
        resolution_(field.geometry().resolution()),
        metres_(field.options().reach / LikelihoodField::kFar) {}

  [[nodiscard]] bool crosses_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const double length = std::min((to - from).norm() - kClearly, kFarthest);
    const Eigen::Vector2d direction = (to - from).normalized();
    for (double at = 0.0; at < length;) {
      const Eigen::Vector2d here = from + at * direction;
      const Cell cell = field_.geometry().cell_at(here);
      const double distance = metres_ * field_.distance(cell);
      if (distance <= kOn * resolution_ && is_within_wall(here, cell, direction)) {
        return true;
      }
      at += std::max(distance - resolution_, 0.5 * resolution_);
    }
    return false;
  }

 private:
  static constexpr double kOn = 0.6;  // of a cell: a wall so near to its centre goes through it

  [[nodiscard]] bool is_on_wall(const Eigen::Vector2d& place) const {
    return metres_ * field_.distance(field_.geometry().cell_at(place)) <= kOn * resolution_;
  }

  /// Whether a wall that the beam does not go along reaches to both sides: beams pass by the edges
  /// of things rightly, and so near that a cell cannot tell.
  [[nodiscard]] bool is_within_wall(const Eigen::Vector2d& here, const Cell& cell,
                                    const Eigen::Vector2d& direction) const {
    Surface surface;
    if (!field_.nearest_surface(cell, surface) || surface.double_angle.norm() < kLine) {
      return false;
    }
    const Eigen::Vector2d doubled = surface.double_angle.normalized();
    const Eigen::Vector2d normal(
        std::sqrt(std::max(0.0, 0.5 * (1.0 + doubled.x()))),
        std::copysign(std::sqrt(std::max(0.0, 0.5 * (1.0 - doubled.x()))), doubled.y()));
    if (std::abs(normal.dot(direction)) < kAlong) {
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

double contradiction(const PointScan& scan, const Pose2& map_from_base,
                     const LikelihoodField& field) {
  const BeamWalk walk(field);
  const Transform2 to_map(map_from_base);
  const std::size_t stride = (scan.points.size() + kBeams - 1) / kBeams;
  double crossing = 0.0;
  double all = 0.0;
  for (std::size_t i = 0; i < scan.points.size(); i += stride) {
    const ScanPoint& point = scan.points[i];
    const Eigen::Vector2d from = to_map * point.origin;
    const Eigen::Vector2d to = to_map * point.position;
    if (!(point.weight > 0.0) || !from.allFinite() || !to.allFinite()) {
      continue;
    }
    all += point.weight;
    crossing += walk.crosses_wall(from, to) ? point.weight : 0.0;
  }
  return all > 0.0 ? crossing / all : 0.0;
}

}  // namespace matchbox_slam
