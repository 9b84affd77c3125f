#include "matchbox_slam/common/random.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The lower left corner is the origin; lanes run along x.
constexpr double kLength = 62.0;
constexpr double kLane = 6.0;
constexpr double kBayDepth = 5.0;
constexpr double kBayWidth = 2.5;
constexpr double kWidth = 4.0 * kBayDepth + 2.0 * kLane;  // two lanes, bays on both sides of each
constexpr double kEnd = 6.0;                              // without bays, at both ends
constexpr double kClearance = 0.65;                       // between the route and everything

/// Out along one lane and back along the other.
Route draw_route(Random& random) {
  constexpr double kSwerve = 0.8;
  const double lower = kBayDepth + 0.5 * kLane;
  const double upper = kWidth - lower;
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  for (const double x : {4.0, 18.0, 32.0, 46.0, 58.0}) {
    route.waypoints.emplace_back(x, lower + random.uniform(-kSwerve, kSwerve));
  }
  for (const double x : {58.0, 46.0, 32.0, 18.0, 4.0}) {
    route.waypoints.emplace_back(x, upper + random.uniform(-kSwerve, kSwerve));
  }
  route.waypoints.push_back(route.waypoints.front());
  return route;
}

/// A row of bays, of which cars stand in some, and a pillar between each third and the next.
/// @param y  of the bays' middle.
void add_row(double y, double pillar_y, Random& random, FloorPlan& plan) {
  constexpr int kBays = 20;
  for (int bay = 0; bay < kBays; ++bay) {
    const double left = kEnd + bay * kBayWidth;
    if (bay % 3 == 0) {
      plan.add(outline(box({left, pillar_y}, {0.4, 0.6}, 0.0)));
    }
    if (random.uniform() < 0.6) {
      const double along = random.uniform(-0.25, 0.25);
      const double aside = random.uniform(-0.12, 0.12);
      const double width = random.uniform(1.6, 1.8);
      const double angle = random.uniform(-0.04, 0.04);
      const double length = random.uniform(3.6, 4.6);
      plan.add_if_clear(
          outline(box({left + 0.5 * kBayWidth + aside, y + along}, {width, length}, angle)),
          kClearance, 0.02);
    }
  }
}

}  // namespace

World make_garage_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  plan.add(outline(box({0.5 * kLength, 0.5 * kWidth}, {kLength, kWidth}, 0.0)));
  constexpr double kPillarOff = 0.6;  // from the lane
  const double middle = 0.5 * kWidth;
  add_row(0.5 * kBayDepth, kBayDepth - kPillarOff, random, plan);
  add_row(middle - 0.5 * kBayDepth, middle - kBayDepth + kPillarOff, random, plan);
  add_row(middle + 0.5 * kBayDepth, middle + kBayDepth - kPillarOff, random, plan);
  add_row(kWidth - 0.5 * kBayDepth, kWidth - kBayDepth + kPillarOff, random, plan);
  return plan.world(seed);
}

}  // namespace matchbox_slam
