#include "matchbox_slam/common/random.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLength = 120.0;        // [m]
constexpr double kWayToBothEnds = 35.0;  // [m], more than the reach of the laser

}  // namespace

World make_corridor_world(std::uint64_t seed) {
  Random random(seed);
  const double width = random.uniform(1.9, 2.6);
  Route route;
  route.waypoints = {{kWayToBothEnds, 0.0}, {kLength - kWayToBothEnds, 0.0}};
  FloorPlan plan(route);
  plan.add(outline(box({0.5 * kLength, 0.0}, {kLength, width}, 0.0)));
  return plan.world();
}

}  // namespace matchbox_slam
