#include <algorithm>
#include <cmath>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"
#include "simulation/room_row.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The corridor runs along the x axis from the origin on.
constexpr double kLength = 24.0;
constexpr double kCorridorHalfWidth = 1.2;
constexpr double kRoomDepth = 6.0;
constexpr double kWallThickness = 0.16;
constexpr double kPost = 0.05;
constexpr double kDoorWidth = 1.1;
constexpr int kRoomsInRow = 4;
constexpr int kVisitedInRow = 3;

// A pane returns beams that meet it nearly head-on; all others pass.
WallSurface glass() {
  WallSurface surface;
  surface.widest_incidence = degrees_to_radians(12.0);
  return surface;
}

void add_post(const Eigen::Vector2d& at, double angle, FloorPlan& plan) {
  plan.add(outline(box(at, {kPost, kPost}, angle)));
}

/// Panes of about one width side by side, with posts between them and at both ends.
void add_panes(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Random& random,
               FloorPlan& plan) {
  const double length = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length;
  const double angle = std::atan2(along.y(), along.x());
  const int count = std::max(1, static_cast<int>(std::lround(length / random.uniform(0.9, 1.5))));
  const double pane = length / count;
  add_post(from, angle, plan);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d start = from + i * pane * along;
    const Eigen::Vector2d end = start + pane * along;
    plan.add(with_surface({{start + 0.5 * kPost * along, end - 0.5 * kPost * along}}, glass()));
    add_post(end, angle, plan);
  }
}

/// The glazed wall between corridor and rooms, with open doors.
void add_glazed_front(const std::vector<Room>& row, Random& random, FloorPlan& plan) {
  const double y = row.front().near_y;
  double start = 0.0;
  for (const Room& room : row) {
    add_panes({start, y}, {room.door_x - 0.5 * kDoorWidth, y}, random, plan);
    start = room.door_x + 0.5 * kDoorWidth;
  }
  add_panes({start, y}, {kLength, y}, random, plan);
}

/// The wall to the street: brickwork with windows down to the floor.
void add_facade(double y, Random& random, FloorPlan& plan) {
  double start = 0.0;
  while (start < kLength) {
    const double window = std::min(kLength, start + random.uniform(0.8, 2.0));
    plan.add_wall({start, y}, {window, y}, kWallThickness);
    start = std::min(kLength, window + random.uniform(1.5, 4.0));
    if (start > window) {
      add_panes({window, y}, {start, y}, random, plan);
    }
  }
}

void add_row(const std::vector<Room>& row, Random& random, FloorPlan& plan) {
  const double near_y = row.front().near_y;
  const double far_y = row.front().far_y;
  add_glazed_front(row, random, plan);
  add_facade(far_y, random, plan);
  for (const Room& room : row) {
    const bool is_last = room.right == kLength;
    if (!is_last && random.uniform() < 0.5) {
      add_panes({room.right, near_y}, {room.right, far_y}, random, plan);
    } else {
      plan.add_wall({room.right, near_y}, {room.right, far_y}, kWallThickness);
    }
    furnish_room(room, kDoorWidth, random, plan);
  }
  plan.add_wall({0.0, near_y}, {0.0, far_y}, kWallThickness);
}

/// @param sign  of y: 1 for the rooms above the corridor.
std::vector<Room> draw_row(double sign, Random& random) {
  Room shape;
  shape.right = kLength;
  shape.near_y = sign * kCorridorHalfWidth;
  shape.far_y = sign * (kCorridorHalfWidth + kRoomDepth);
  return draw_room_row(shape, kRoomsInRow, random);
}

/// Along the corridor and back, with visits to rooms.
Route draw_route(const std::vector<Room>& upper, const std::vector<Room>& lower, Random& random) {
  const Eigen::Vector2d start(1.2, 0.0);
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  route.waypoints.push_back(start);
  for (const Room& room : draw_visited(upper, kVisitedInRow, random)) {
    visit_room(room, 0.0, random, route.waypoints);
  }
  const std::vector<Room> back = draw_visited(lower, kVisitedInRow, random);
  for (auto room = back.rbegin(); room != back.rend(); ++room) {
    visit_room(*room, 0.0, random, route.waypoints);
  }
  route.waypoints.push_back(start);
  return route;
}

}  // namespace

World make_glass_world(std::uint64_t seed) {
  Random random(seed);
  const std::vector<Room> upper = draw_row(1.0, random);
  const std::vector<Room> lower = draw_row(-1.0, random);
  FloorPlan plan(draw_route(upper, lower, random));
  add_row(upper, random, plan);
  add_row(lower, random, plan);
  for (const double x : {0.0, kLength}) {
    plan.add_wall({x, -kCorridorHalfWidth}, {x, kCorridorHalfWidth}, kWallThickness);
  }
  furnish_corridor(kLength, 0.0, kCorridorHalfWidth, random, plan);
  return plan.world(seed);
}

}  // namespace matchbox_slam
