#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The street runs along the x axis; both its ends are open to the sky.
constexpr double kLength = 46.0;
constexpr double kHalfWay = 1.6;     // from the axis to the way out, and to the way back
constexpr double kKerb = 3.6;        // from the axis to the middle of parked cars
constexpr double kTrees = 5.6;       // and to trunks
constexpr double kHedges = 7.4;      // and to hedges
constexpr double kFronts = 9.5;      // and to the nearest fronts
constexpr double kClearance = 0.65;  // between the route and everything
constexpr double kGap = 0.3;         // between one thing and the next

/// Out on one side of the street and back on the other.
Route draw_route(Random& random) {
  constexpr double kPointSpacing = 6.0;
  constexpr double kEndClearance = 4.0;
  constexpr double kSwerve = 0.25;
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  for (double x = kEndClearance; x <= kLength - kEndClearance; x += kPointSpacing) {
    route.waypoints.emplace_back(x, -kHalfWay + random.uniform(-kSwerve, kSwerve));
  }
  const std::size_t out = route.waypoints.size();
  for (std::size_t i = out; i > 0; --i) {
    route.waypoints.emplace_back(route.waypoints[i - 1].x(),
                                 kHalfWay + random.uniform(-kSwerve, kSwerve));
  }
  route.waypoints.push_back(route.waypoints.front());
  return route;
}

/// A house, with a porch or a bay before it.
/// @param side  1 above the street, -1 below.
void add_house(double left, double right, double side, Random& random, FloorPlan& plan) {
  constexpr double kDepth = 6.0;
  const double front = kFronts + random.uniform(0.0, 2.0);
  const double middle = 0.5 * (left + right);
  plan.add_if_clear(
      outline(box({middle, side * (front + 0.5 * kDepth)}, {right - left, kDepth}, 0.0)),
      kClearance, 0.0);
  const double width = random.uniform(1.2, 2.5);
  const double depth = random.uniform(0.3, 1.2);
  const double x = random.uniform(left + 0.5 * width, right - 0.5 * width);
  plan.add_if_clear(outline(box({x, side * (front - 0.5 * depth - 0.02)}, {width, depth}, 0.0)),
                    kClearance, 0.0);
}

/// House fronts with gaps between them, through which nothing is seen.
void add_houses(double side, Random& random, FloorPlan& plan) {
  double left = random.uniform(-4.0, 3.0);
  while (left < kLength - 4.0) {
    const double right = left + random.uniform(5.0, 8.0);
    add_house(left, right, side, random, plan);
    left = right + random.uniform(5.0, 12.0);
  }
}

void add_hedges(double side, Random& random, FloorPlan& plan) {
  constexpr double kThickness = 0.8;
  double left = random.uniform(-2.0, 6.0);
  while (left < kLength) {
    const double length = random.uniform(2.0, 5.0);
    const double y = side * (kHedges + random.uniform(-0.3, 0.3));
    plan.add_if_clear(with_surface(outline(box({left + 0.5 * length, y}, {length, kThickness},
                                               random.uniform(-0.05, 0.05))),
                                   leaves(0.3)),
                      kClearance, kGap);
    left += length + random.uniform(4.0, 14.0);
  }
}

void add_trees(double side, Random& random, FloorPlan& plan) {
  constexpr int kCorners = 16;
  for (double x = random.uniform(0.0, 5.0); x < kLength; x += random.uniform(4.5, 9.0)) {
    const Eigen::Vector2d centre(x, side * (kTrees + random.uniform(-0.3, 0.3)));
    plan.add_if_clear(outline(regular_polygon(centre, random.uniform(0.12, 0.3), kCorners, 0.0)),
                      kClearance, kGap);
  }
}

/// At the height of a laser a car is a box with its corners cut.
Corners car(const Eigen::Vector2d& centre, double length, double width, double angle) {
  constexpr double kCut = 0.35;
  const Corners corners = box(centre, {length, width}, angle);
  Corners cut;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& corner = corners[i];
    const Eigen::Vector2d before = corners[(i + 3) % 4] - corner;
    const Eigen::Vector2d after = corners[(i + 1) % 4] - corner;
    cut.emplace_back(corner + kCut * before.normalized());
    cut.emplace_back(corner + kCut * after.normalized());
  }
  return cut;
}

void add_cars(double side, Random& random, FloorPlan& plan) {
  double x = random.uniform(0.0, 10.0);
  while (x < kLength) {
    const double length = random.uniform(3.8, 4.8);
    const double width = random.uniform(1.65, 1.9);
    const double y = side * (kKerb + random.uniform(-0.1, 0.15));
    const double angle = random.uniform(-0.04, 0.04);
    plan.add_if_clear(outline(car({x, y}, length, width, angle)), kClearance, kGap);
    x += length + random.uniform(3.0, 18.0);
  }
}

}  // namespace

World make_street_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  for (const double side : {-1.0, 1.0}) {
    add_houses(side, random, plan);
    add_cars(side, random, plan);
    add_trees(side, random, plan);
    add_hedges(side, random, plan);
  }
  return plan.world(seed);
}

}  // namespace matchbox_slam
