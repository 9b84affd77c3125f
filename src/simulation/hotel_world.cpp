#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "simulation/corridor_net.hpp"
#include "simulation/equal_rooms.hpp"
#include "simulation/make_world.hpp"
#include "simulation/solid_plan.hpp"

namespace matchbox_slam {
namespace {

constexpr int kCorridors = 3;
constexpr double kMargin = 2.0;  // [m]
constexpr double kTour = 350.0;  // [m], and the way home, and in and out of rooms

/// A multiple of 0.2 m, so that halves are of 0.1 m, and all rooms are equal in the plan.
double draw_length(double low, double high, Random& random) {
  return 0.2 * std::round(5.0 * random.uniform(low, high));
}

EqualRooms draw_rooms(Random& random) {
  EqualRooms rooms;
  rooms.corridor_half_width = draw_length(1.0, 1.4, random);
  rooms.pitch = draw_length(3.4, 4.8, random);
  rooms.depth = draw_length(4.0, 6.0, random);
  rooms.visits = 0.15;
  return rooms;
}

}  // namespace

World make_hotel_world(std::uint64_t seed) {
  Random random(seed);
  const EqualRooms rooms = draw_rooms(random);
  const double doors = std::floor(random.uniform(10.0, 14.0));
  const double length = doors * rooms.pitch + 2.0 * rooms.reach();
  const double between = 2.0 * rooms.reach() + rooms.wall;  // back to back
  const double side = kMargin + rooms.reach();
  SolidPlan plan({length + 2.0 * side, (kCorridors - 1) * between + 2.0 * side});
  CorridorNet net;
  for (int i = 0; i < kCorridors; ++i) {
    const Eigen::Vector2d left(side, side + i * between);
    const Eigen::Vector2d right = left + Eigen::Vector2d(length, 0.0);
    net.add(left, right);
    cut_rooms(left, right, rooms, random, plan);
    cut_corridor(left, right, rooms, plan);
    if (i + 1 < kCorridors) {
      for (const Eigen::Vector2d& end : {left, right}) {
        net.add(end, end + Eigen::Vector2d(0.0, between));
        cut_corridor(end, end + Eigen::Vector2d(0.0, between), rooms, plan);
      }
    }
  }
  return {plan.walls(), draw_route(net, kTour, rooms, random)};
}

}  // namespace matchbox_slam
