#include "matchbox_slam/common/random.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The lower left corner is the origin; rows of plants stand along x.
constexpr double kLength = 34.0;
constexpr int kRows = 7;
constexpr double kRowSpacing = 2.4;
constexpr double kWidth = (kRows + 1) * kRowSpacing;
constexpr double kRowBegin = 4.0;
constexpr double kRowEnd = kLength - 4.0;

/// Between the rows, there and back, and home along the wall.
Route draw_route(Random& random) {
  constexpr double kSwerve = 0.1;
  constexpr double kHeadland = 1.8;  // between the rows and the way around them
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  for (int row = 0; row + 1 < kRows; ++row) {
    const double y = (row + 1.5) * kRowSpacing;
    const double begin = row % 2 == 0 ? kRowBegin - kHeadland : kRowEnd + kHeadland;
    route.waypoints.emplace_back(begin, y + random.uniform(-kSwerve, kSwerve));
    route.waypoints.emplace_back(kLength - begin, y + random.uniform(-kSwerve, kSwerve));
  }
  route.waypoints.push_back(route.waypoints.front());
  return route;
}

/// Plants as they grow, with gaps, and a post at times.
void add_row(double y, Random& random, FloorPlan& plan) {
  for (double x = kRowBegin; x < kRowEnd;) {
    const double length = random.uniform(0.3, 1.2);
    const double width = random.uniform(0.3, 0.8);
    plan.add(
        with_surface(outline(box({x + 0.5 * length, y}, {length, width}, 0.0)), leaves(0.25, 0.2)));
    x += length + random.uniform(0.02, 0.4);
  }
  constexpr double kPosts = 6.0;
  for (double x = kRowBegin; x <= kRowEnd; x += kPosts) {
    plan.add(outline(box({x, y + 0.45}, {0.08, 0.08}, 0.0)));
  }
}

}  // namespace

World make_greenhouse_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  plan.add(outline(box({0.5 * kLength, 0.5 * kWidth}, {kLength, kWidth}, 0.0)));
  for (int row = 0; row < kRows; ++row) {
    add_row((row + 1) * kRowSpacing, random, plan);
  }
  return plan.world(seed);
}

}  // namespace matchbox_slam
