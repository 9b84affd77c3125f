#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

// Half the sides of the square of clutter and of the denser ring around it [m].
constexpr double kClutterHalfSide = 10.0;
constexpr double kRingHalfSide = 12.5;
// How many things are tried; a few stand in the robot's way and are left out.
constexpr int kThingsInside = 260;
constexpr int kThingsInRing = 480;
constexpr double kClearance = 0.7;  // [m] between the route and everything

Route draw_route(Random& random) {
  constexpr int kPoints = 9;
  Route route;
  const double first = random.uniform(-kPi, kPi);
  for (int i = 0; i < kPoints; ++i) {
    route.waypoints.push_back(polar(random.uniform(3.5, 8.0), first + 2.0 * kPi * i / kPoints));
  }
  route.waypoints.push_back(route.waypoints[0]);
  route.waypoints.push_back(route.waypoints[1]);
  route.start_heading = random.uniform(-kPi, kPi);
  return route;
}

std::vector<WallSegment> draw_single(const Eigen::Vector2d& centre, Random& random) {
  const double length = random.uniform(0.15, 0.55);
  const Eigen::Vector2d half = polar(0.5 * length, random.uniform(-kPi, kPi));
  return {{centre - half, centre + half}};
}

std::vector<WallSegment> draw_polygon(const Eigen::Vector2d& centre, Random& random) {
  const int count = 3 + static_cast<int>(random.uniform(0.0, 4.0));
  const double first = random.uniform(-kPi, kPi);
  Corners corners;
  for (int i = 0; i < count; ++i) {
    const double angle = first + 2.0 * kPi * (i + random.uniform(-0.25, 0.25)) / count;
    corners.emplace_back(centre + polar(random.uniform(0.1, 0.3), angle));
  }
  return outline(corners);
}

std::vector<WallSegment> draw_zigzag(const Eigen::Vector2d& centre, Random& random) {
  const int count = 3 + static_cast<int>(random.uniform(0.0, 3.0));
  double angle = random.uniform(-kPi, kPi);
  Corners corners = {centre};
  for (int i = 0; i < count; ++i) {
    corners.emplace_back(corners.back() + polar(random.uniform(0.1, 0.35), angle));
    // At least 20 degrees off straight on, so that the pieces do not make one line.
    const double turn = random.uniform(0.35, 1.8);
    angle += random.uniform() < 0.5 ? -turn : turn;
  }
  return open_line(corners);
}

std::vector<WallSegment> draw_thing(const Eigen::Vector2d& centre, Random& random) {
  const double kind = random.uniform();
  if (kind < 0.5) {
    return draw_single(centre, random);
  }
  return kind < 0.8 ? draw_polygon(centre, random) : draw_zigzag(centre, random);
}

Eigen::Vector2d draw_point(double half_side, Random& random) {
  const double x = random.uniform(-half_side, half_side);
  const double y = random.uniform(-half_side, half_side);
  return {x, y};
}

}  // namespace

World make_random_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  for (int i = 0; i < kThingsInside; ++i) {
    const Eigen::Vector2d centre = draw_point(kClutterHalfSide, random);
    plan.add_if_clear(draw_thing(centre, random), kClearance, 0.0);
  }
  for (int i = 0; i < kThingsInRing;) {
    const Eigen::Vector2d centre = draw_point(kRingHalfSide, random);
    if (centre.cwiseAbs().maxCoeff() > kClutterHalfSide) {
      plan.add_if_clear(draw_thing(centre, random), kClearance, 0.0);
      ++i;
    }
  }
  return plan.world();
}

}  // namespace matchbox_slam
