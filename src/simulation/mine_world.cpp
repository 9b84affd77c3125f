#include <algorithm>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr int kSides = 360;         // of a ring's wall
constexpr double kHalfWidth = 1.7;  // [m] of the tunnel
constexpr double kRoughness = 0.5;  // [m], at most

/// The middle of a ring of rock, as its radius by the angle.
struct Ring {
  double phase_of_two = 0.0;
  double phase_of_three = 0.0;

  [[nodiscard]] Eigen::Vector2d at(double angle, double outwards) const {
    const double radius = 15.0 + 3.5 * std::sin(2.0 * angle + phase_of_two) +
                          2.0 * std::sin(3.0 * angle + phase_of_three) + outwards;
    return polar(radius, angle);
  }
};

Route draw_route(const Ring& ring, Random& random) {
  constexpr int kPoints = 40;
  const double first = random.uniform(-kPi, kPi);
  Route route;
  for (int i = 0; i < kPoints; ++i) {
    route.waypoints.push_back(
        ring.at(first + 2.0 * kPi * i / kPoints, random.uniform(-0.15, 0.15)));
  }
  route.waypoints.push_back(route.waypoints.front());
  const Eigen::Vector2d ahead = route.waypoints[1] - route.waypoints[0];
  route.start_heading = std::atan2(ahead.y(), ahead.x());
  return route;
}

/// One wall of the tunnel: rough rock, as a random walk that is drawn back to the middle.
Corners draw_wall(const Ring& ring, double outwards, Random& random) {
  Corners corners;
  double rough = 0.0;
  for (int i = 0; i < kSides; ++i) {
    rough = std::clamp(0.85 * rough + random.uniform(-0.2, 0.2), -kRoughness, kRoughness);
    corners.push_back(ring.at(2.0 * kPi * i / kSides, outwards + rough));
  }
  return corners;
}

}  // namespace

World make_mine_world(std::uint64_t seed) {
  Random random(seed);
  Ring ring;
  ring.phase_of_two = random.uniform(-kPi, kPi);
  ring.phase_of_three = random.uniform(-kPi, kPi);
  FloorPlan plan(draw_route(ring, random));
  plan.add(outline(draw_wall(ring, -kHalfWidth, random)));
  plan.add(outline(draw_wall(ring, kHalfWidth, random)));
  return plan.world(seed);
}

}  // namespace matchbox_slam
