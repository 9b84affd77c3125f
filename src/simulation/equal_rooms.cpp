#include "simulation/equal_rooms.hpp"

#include <cmath>

namespace matchbox_slam {
namespace {

/// The middle of the corridor at each door.
std::vector<Eigen::Vector2d> places_of_doors(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                             const EqualRooms& rooms) {
  const double length = (to - from).norm();
  const double spare = length - 2.0 * rooms.reach() - rooms.pitch;
  std::vector<Eigen::Vector2d> places;
  if (spare >= 0.0) {
    const double last = std::floor(spare / rooms.pitch);
    for (double i = 0.0; i <= last; ++i) {
      const double at = 0.5 * length + (i - 0.5 * last) * rooms.pitch;
      places.emplace_back(from + at / length * (to - from));
    }
  }
  return places;
}

double draw_side(Random& random) { return random.uniform() < 0.5 ? -1.0 : 1.0; }

}  // namespace

void cut_corridor(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const EqualRooms& rooms,
                  SolidPlan& plan) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(rooms.corridor_half_width);
  plan.cut(from.cwiseMin(to) - half, from.cwiseMax(to) + half);
}

void cut_rooms(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const EqualRooms& rooms,
               Random& random, SolidPlan& plan) {
  constexpr double kCabinetDepth = 0.3;
  const Eigen::Vector2d along = (to - from).normalized();
  const double near = rooms.corridor_half_width;
  for (const Eigen::Vector2d& place : places_of_doors(from, to, rooms)) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d across = side * Eigen::Vector2d(-along.y(), along.x());
      const auto at = [&](double ahead, double aside) {
        return Eigen::Vector2d(place + ahead * along + aside * across);
      };
      const bool is_open = random.uniform() < rooms.open;
      const double threshold = is_open ? rooms.wall : rooms.recess;
      plan.cut(at(-0.5 * rooms.door, near), at(0.5 * rooms.door, near + threshold));
      if (is_open) {
        const double half = 0.5 * (rooms.pitch - rooms.wall);
        plan.cut(at(-half, near + rooms.wall), at(half, rooms.reach()));
      }
      if (random.uniform() < rooms.cabinets) {
        plan.fill(at(rooms.door, near - kCabinetDepth), at(rooms.door + 0.8, near));
      }
    }
  }
}

Route draw_route(const CorridorNet& net, double length, const EqualRooms& rooms, Random& random) {
  constexpr double kRoomEntryDepth = 1.5;  // [m] behind the door
  constexpr double kSwerve = 0.12;
  const std::vector<std::size_t> tour = net.tour(length, random);
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  route.waypoints.push_back(net.crossings()[tour.front()]);
  for (std::size_t i = 1; i < tour.size(); ++i) {
    const Eigen::Vector2d& from = net.crossings()[tour[i - 1]];
    const Eigen::Vector2d& to = net.crossings()[tour[i]];
    const Eigen::Vector2d along = (to - from).normalized();
    const Eigen::Vector2d across = draw_side(random) * Eigen::Vector2d(-along.y(), along.x());
    for (const Eigen::Vector2d& door : places_of_doors(from, to, rooms)) {
      if (random.uniform() < rooms.visits) {
        const double aside = rooms.corridor_half_width + rooms.wall + kRoomEntryDepth;
        route.waypoints.insert(route.waypoints.end(), {door, door + aside * across, door});
      } else {
        route.waypoints.emplace_back(door + random.uniform(-kSwerve, kSwerve) * across);
      }
    }
    route.waypoints.push_back(to);
  }
  return route;
}

}  // namespace matchbox_slam
