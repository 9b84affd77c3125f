#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kHalfSide = 27.0;   // [m] of the square in which things stand
constexpr double kClearance = 0.65;  // [m] between the route and everything
constexpr double kGap = 0.4;         // [m] between one thing and the next

/// A winding path around the middle.
Route draw_route(Random& random) {
  constexpr int kPoints = 16;
  const double first = random.uniform(-kPi, kPi);
  const double phase = random.uniform(-kPi, kPi);
  Route route;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * kPi * i / kPoints;
    const double radius = 14.0 + 3.5 * std::sin(3.0 * angle + phase) + random.uniform(-0.5, 0.5);
    route.waypoints.push_back(polar(radius, first + angle));
  }
  route.waypoints.push_back(route.waypoints.front());
  route.start_heading = random.uniform(-kPi, kPi);
  return route;
}

Eigen::Vector2d draw_place(Random& random) {
  const double x = random.uniform(-kHalfSide, kHalfSide);
  const double y = random.uniform(-kHalfSide, kHalfSide);
  return {x, y};
}

}  // namespace

World make_park_world(std::uint64_t seed) {
  constexpr int kTrees = 150;
  constexpr int kBushes = 40;
  constexpr int kBenches = 16;
  constexpr int kTrunkCorners = 14;
  Random random(seed);
  FloorPlan plan(draw_route(random));
  for (int i = 0; i < kTrees; ++i) {
    const Eigen::Vector2d centre = draw_place(random);
    plan.add_if_clear(
        outline(regular_polygon(centre, random.uniform(0.08, 0.35), kTrunkCorners, 0.0)),
        kClearance, kGap);
  }
  for (int i = 0; i < kBushes; ++i) {
    const Eigen::Vector2d centre = draw_place(random);
    const double radius = random.uniform(0.4, 1.2);
    plan.add_if_clear(with_surface(outline(regular_polygon(centre, radius, 9, 0.0)), leaves(0.3)),
                      kClearance, kGap);
  }
  for (int i = 0; i < kBenches; ++i) {
    const Eigen::Vector2d centre = draw_place(random);
    plan.add_if_clear(outline(box(centre, {1.6, 0.5}, random.uniform(-kPi, kPi))), kClearance,
                      kGap);
  }
  return plan.world(seed);
}

}  // namespace matchbox_slam
