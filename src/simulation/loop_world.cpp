#include <algorithm>
#include <array>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kSide = 25.0;       // [m] of the square that the middle of the corridor follows
constexpr double kHalfWidth = 1.1;   // [m] of the corridor
constexpr double kOverlap = 16.0;    // [m] that the route goes on after one lap
constexpr double kCornerFree = 1.2;  // [m] of plain wall on both sides of a corner

/// A piece of wall that stands out of the wall by `depth`, or back into it where that is negative.
struct Relief {
  double length;  ///< [m]
  double depth;   ///< [m]
};

Relief draw_relief(Random& random) {
  const double kind = random.uniform();
  if (kind < 0.40) {  // a door, shut, in its recess
    return {random.uniform(0.85, 1.05), -random.uniform(0.06, 0.25)};
  }
  if (kind < 0.55) {  // a niche or a small open room
    return {random.uniform(1.0, 2.5), -random.uniform(0.6, 2.5)};
  }
  if (kind < 0.70) {  // a pillar
    return {random.uniform(0.3, 0.6), random.uniform(0.12, 0.3)};
  }
  if (kind < 0.85) {  // a cabinet
    return {random.uniform(0.8, 1.5), random.uniform(0.3, 0.42)};
  }
  return {random.uniform(0.8, 1.6), random.uniform(0.07, 0.14)};  // a radiator
}

/// A wall from corner to corner with reliefs at irregular places. `towards_corridor` is the unit
/// vector that a positive depth stands out along.
std::vector<WallSegment> draw_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                   const Eigen::Vector2d& towards_corridor, Random& random) {
  const double length = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length;
  Corners corners = {from};
  double at = kCornerFree + random.uniform(0.0, 2.5);
  while (true) {
    const Relief relief = draw_relief(random);
    const double end = at + relief.length;
    if (end > length - kCornerFree) {
      break;
    }
    // Deep niches stay away from the corners, where those of the next wall could meet them.
    const bool fits = -relief.depth < std::min(at, length - end) - 0.3;
    const double depth = fits ? relief.depth : -0.1;
    corners.emplace_back(from + at * along);
    corners.emplace_back(from + at * along + depth * towards_corridor);
    corners.emplace_back(from + end * along + depth * towards_corridor);
    corners.emplace_back(from + end * along);
    at = end + random.uniform(0.4, 3.5);
  }
  corners.push_back(to);
  return open_line(corners);
}

/// Corners of a square about the origin, counter-clockwise.
std::array<Eigen::Vector2d, 4> square(double side) {
  const double half = 0.5 * side;
  return {{{-half, -half}, {half, -half}, {half, half}, {-half, half}}};
}

/// Follows the middle of the corridor, swerving a little as a driver does.
Route draw_route(Random& random) {
  constexpr double kPointSpacing = 4.0;
  const std::array<Eigen::Vector2d, 4> corners = square(kSide);
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  const double start = 0.5 * kSide;
  const double end = start + 4.0 * kSide + kOverlap;
  for (double at = start; at <= end;) {
    const int side = static_cast<int>(at / kSide);
    const double on_side = at - side * kSide;
    const Eigen::Vector2d& from = corners[static_cast<std::size_t>(side % 4)];
    const Eigen::Vector2d along =
        (corners[static_cast<std::size_t>((side + 1) % 4)] - from) / kSide;
    const double swerve = on_side == 0.0 ? 0.0 : random.uniform(-0.12, 0.12);
    route.waypoints.emplace_back(from + on_side * along +
                                 swerve * Eigen::Vector2d(-along.y(), along.x()));
    // A point on each corner, and none so near before it that the line to it is askew.
    const double next_corner = (side + 1) * kSide;
    const double next = at + 1.5 * kPointSpacing > next_corner ? next_corner : at + kPointSpacing;
    at = at < end ? std::min(next, end) : next;
  }
  return route;
}

}  // namespace

World make_loop_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  for (const double side_of_corridor : {1.0, -1.0}) {
    const std::array<Eigen::Vector2d, 4> corners =
        square(kSide + 2.0 * side_of_corridor * kHalfWidth);
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d& from = corners[i];
      const Eigen::Vector2d& to = corners[(i + 1) % 4];
      const Eigen::Vector2d inwards = WallSegment{from, to}.normal();
      plan.add(draw_wall(from, to, side_of_corridor * inwards, random));
    }
  }
  return plan.world();
}

}  // namespace matchbox_slam
