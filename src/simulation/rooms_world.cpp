#include <algorithm>
#include <cmath>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"
#include "simulation/room_furniture.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The building's lower left corner is the origin.
constexpr double kBuildingLength = 22.0;
constexpr double kBuildingDepth = 20.0;
constexpr double kCorridorHalfWidth = 1.1;
constexpr double kWallThickness = 0.16;
constexpr double kDoorWidth = 1.1;
constexpr double kDoorApproach = 0.9;  // the route is straight so far before and behind a door

/// The building: a corridor along x with a row of rooms on either side.
struct Building {
  double corridor_y;
  std::vector<Room> upper;  ///< from left to right
  std::vector<Room> lower;
};

/// One row of rooms between two walls along x, with doors to the corridor and between some rooms.
std::vector<Room> draw_row(double near_y, double far_y, Random& random) {
  const int count = random.uniform() < 0.5 ? 3 : 4;
  const double mean_width = kBuildingLength / count;
  std::vector<Room> rooms;
  double left = 0.0;
  for (int i = 0; i < count; ++i) {
    Room room;
    room.left = left;
    room.right = i + 1 == count ? kBuildingLength
                                : mean_width * (i + 1) + random.uniform(-0.12, 0.12) * mean_width;
    room.near_y = near_y;
    room.far_y = far_y;
    room.door_x = random.uniform(room.left + 1.5, room.right - 1.5);
    room.is_open_to_next = i + 1 < count && random.uniform() < 0.6;
    room.next_door_y = near_y + random.uniform(0.3, 0.75) * (far_y - near_y);
    left = room.right;
    rooms.push_back(room);
  }
  return rooms;
}

Building draw_building(Random& random) {
  Building building;
  building.corridor_y = random.uniform(0.45, 0.55) * kBuildingDepth;
  building.upper = draw_row(building.corridor_y + kCorridorHalfWidth, kBuildingDepth, random);
  building.lower = draw_row(building.corridor_y - kCorridorHalfWidth, 0.0, random);
  return building;
}

/// Tours the rooms of a row in the order given: from the corridor, through the doors between the
/// rooms where there are any, and back to the corridor.
class RowTour {
 public:
  RowTour(double corridor_y, Corners& route) : corridor_y_(corridor_y), route_(route) {}

  void enter(const Room& room) {
    route_.emplace_back(room.door_x, corridor_y_);
    route_.emplace_back(room.door_x, room.near_y + room.inwards() * kDoorApproach);
  }

  void leave(const Room& room) {
    route_.emplace_back(room.door_x, room.near_y + room.inwards() * kDoorApproach);
    route_.emplace_back(room.door_x, corridor_y_);
  }

  void pass(const Room& left, bool rightwards) {
    const double step = rightwards ? kDoorApproach : -kDoorApproach;
    route_.emplace_back(left.right - step, left.next_door_y);
    route_.emplace_back(left.right + step, left.next_door_y);
  }

  void look_around(const Room& room, bool rightwards, Random& random) {
    const double first = random.uniform(0.3, 0.4);
    const double second = random.uniform(0.6, 0.7);
    for (const double along : {rightwards ? first : second, rightwards ? second : first}) {
      const double deep = random.uniform(0.3, 0.55);
      route_.emplace_back(room.left + along * (room.right - room.left),
                          room.near_y + deep * (room.far_y - room.near_y));
    }
  }

 private:
  double corridor_y_;
  Corners& route_;
};

/// From the first room to the last, or back.
void tour_row(const std::vector<Room>& row, bool rightwards, RowTour& tour, Random& random) {
  for (std::size_t k = 0; k < row.size(); ++k) {
    const std::size_t i = rightwards ? k : row.size() - 1 - k;
    // The rooms whose right walls have the doors to the rooms before and after this one.
    const Room* left = i > 0 ? &row[i - 1] : nullptr;
    const Room* before = rightwards ? left : &row[i];
    const Room* after = rightwards ? &row[i] : left;
    if (before != nullptr && before->is_open_to_next) {
      tour.pass(*before, rightwards);
    } else {
      tour.enter(row[i]);
    }
    tour.look_around(row[i], rightwards, random);
    if (after == nullptr || !after->is_open_to_next) {
      tour.leave(row[i]);
    }
  }
}

Route draw_route(const Building& building, Random& random) {
  Route route;
  const Eigen::Vector2d start(1.2, building.corridor_y);
  route.waypoints.push_back(start);
  RowTour tour(building.corridor_y, route.waypoints);
  tour_row(building.upper, true, tour, random);
  tour_row(building.lower, false, tour, random);
  route.waypoints.push_back(start);
  route.start_heading = random.uniform(-0.5, 0.5);
  return route;
}

void add_row_walls(const std::vector<Room>& row, FloorPlan& plan) {
  std::vector<double> doors;
  for (const Room& room : row) {
    doors.push_back(room.door_x);
  }
  const double near_y = row.front().near_y;
  const double far_y = row.front().far_y;
  plan.add_wall({0.0, near_y}, {kBuildingLength, near_y}, kWallThickness, doors, kDoorWidth);
  for (std::size_t i = 0; i + 1 < row.size(); ++i) {
    const double x = row[i].right;
    std::vector<double> openings;
    if (row[i].is_open_to_next) {
      openings.push_back(std::abs(row[i].next_door_y - near_y));
    }
    plan.add_wall({x, near_y}, {x, far_y}, kWallThickness, openings, kDoorWidth);
  }
}

}  // namespace

World make_rooms_world(std::uint64_t seed) {
  Random random(seed);
  const Building building = draw_building(random);
  FloorPlan plan(draw_route(building, random));
  plan.add(outline(
      box({0.5 * kBuildingLength, 0.5 * kBuildingDepth}, {kBuildingLength, kBuildingDepth}, 0.0)));
  for (const std::vector<Room>* row : {&building.upper, &building.lower}) {
    add_row_walls(*row, plan);
    for (const Room& room : *row) {
      furnish_room(room, kDoorWidth, random, plan);
    }
  }
  furnish_corridor(kBuildingLength, building.corridor_y, kCorridorHalfWidth, random, plan);
  return plan.world();
}

}  // namespace matchbox_slam
