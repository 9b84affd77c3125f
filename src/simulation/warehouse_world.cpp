#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The lower left corner is the origin; racks stand along x, aisles between them.
constexpr double kLength = 44.0;
constexpr double kWidth = 27.0;
constexpr int kRacks = 5;
constexpr double kAisle = 5.0;      // from the middle of one rack to that of the next
constexpr double kFirstRack = 3.5;  // y of its middle
constexpr double kRackDepth = 2.4;  // of two that stand back to back
constexpr double kRackBegin = 6.0;  // x
constexpr double kBay = 2.7;        // from one upright to the next
constexpr int kBays = 12;
constexpr double kUpright = 0.1;
constexpr double kClearance = 0.65;  // between the route and everything

/// Through all aisles, there and back, and home along the wall.
Route draw_route(Random& random) {
  constexpr double kSwerve = 0.2;
  const double left = kRackBegin - 3.0;
  const double right = kRackBegin + kBays * kBay + 2.5;
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  for (int aisle = 0; aisle + 1 < kRacks; ++aisle) {
    const double y = kFirstRack + (aisle + 0.5) * kAisle;
    const bool is_out = aisle % 2 == 0;
    route.waypoints.emplace_back(is_out ? left : right, y + random.uniform(-kSwerve, kSwerve));
    route.waypoints.emplace_back(0.5 * (left + right), y + random.uniform(-kSwerve, kSwerve));
    route.waypoints.emplace_back(is_out ? right : left, y + random.uniform(-kSwerve, kSwerve));
  }
  route.waypoints.push_back(route.waypoints.front());
  return route;
}

/// Uprights, and pallets of which each stands a little elsewhere, or is missing.
void add_rack(double middle_y, Random& random, FloorPlan& plan) {
  for (const double side : {-1.0, 1.0}) {
    const double front = middle_y + side * 0.5 * kRackDepth;
    for (int i = 0; i <= kBays; ++i) {
      plan.add(outline(box({kRackBegin + i * kBay, front}, {kUpright, kUpright}, 0.0)));
    }
    for (int bay = 0; bay < kBays; ++bay) {
      for (const double at : {0.3, 0.7}) {
        if (random.uniform() < 0.3) {
          continue;
        }
        const double x = kRackBegin + (bay + at) * kBay + random.uniform(-0.06, 0.06);
        const double back = random.uniform(0.0, 0.25);
        const double angle = random.uniform(-0.04, 0.04);
        const double width = random.uniform(0.75, 0.95);
        const double depth = random.uniform(0.7, 0.9);
        plan.add(outline(box({x, front - side * (0.5 + back)}, {width, depth}, angle)));
      }
    }
  }
}

}  // namespace

World make_warehouse_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  plan.add(outline(box({0.5 * kLength, 0.5 * kWidth}, {kLength, kWidth}, 0.0)));
  for (int rack = 0; rack < kRacks; ++rack) {
    add_rack(kFirstRack + rack * kAisle, random, plan);
  }
  constexpr int kPalletsOnTheFloor = 14;
  for (int i = 0; i < kPalletsOnTheFloor; ++i) {
    const double x = random.uniform() < 0.5 ? random.uniform(0.8, 4.5) : random.uniform(39.5, 43.0);
    const double angle = random.uniform(-kPi, kPi);
    const double y = random.uniform(1.0, kWidth - 1.0);
    plan.add_if_clear(outline(box({x, y}, {1.2, 0.8}, angle)), kClearance, 0.3);
  }
  return plan.world(seed);
}

}  // namespace matchbox_slam
