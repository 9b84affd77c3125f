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

// All in metres. The atrium, and the corridor around it, are rectangles with a half circle at
// either end, about the origin.
constexpr double kStraightHalfLength = 8.0;  // from the origin to the middle of a half circle
constexpr double kRailing = 5.0;             // from the middle line to the railing
constexpr double kOuterWall = 7.6;           // and to the wall opposite
constexpr double kMiddle = 0.5 * (kRailing + kOuterWall);
constexpr double kRoomDepth = 4.6;
constexpr double kWallThickness = 0.16;
constexpr double kDoorWidth = 1.1;
constexpr double kClearance = 0.65;  // between the route and what stands in the corridor
constexpr int kRoomsInRow = 4;
constexpr int kVisitedInRow = 2;

// Between its bars half of the beams pass.
WallSurface railing() {
  WallSurface surface;
  surface.passing = 0.5;
  return surface;
}

/// The point of a half circle at one end, `turn` from its beginning on.
/// @param side  1 for the end on the right, -1 for that on the left.
Eigen::Vector2d on_end(double side, double radius, double turn) {
  const double angle = turn - 0.5 * kPi;
  return side *
         Eigen::Vector2d(kStraightHalfLength + radius * std::cos(angle), radius * std::sin(angle));
}

/// Counter-clockwise, in steps of `step` [rad].
void append_end(double side, double radius, double step, Corners& corners) {
  const int steps = static_cast<int>(std::lround(kPi / step));
  for (int i = 0; i <= steps; ++i) {
    corners.push_back(on_end(side, radius, kPi * i / steps));
  }
}

Corners stadium(double radius) {
  constexpr double kStep = degrees_to_radians(2.0);
  Corners corners;
  append_end(1.0, radius, kStep, corners);
  append_end(-1.0, radius, kStep, corners);
  return corners;
}

/// The outer wall of an end, round, with doors, shut, in their recesses at irregular places.
Corners draw_round_wall(double side, Random& random) {
  constexpr double kStep = degrees_to_radians(2.0);
  Corners corners;
  double turn = 0.0;
  while (turn < kPi) {
    const double recess = std::min(kPi, turn + random.uniform(0.2, 0.6));
    for (; turn < recess; turn += kStep) {
      corners.push_back(on_end(side, kOuterWall, turn));
    }
    const double depth = random.uniform(0.08, 0.25);
    const double recess_end = recess + random.uniform(0.9, 1.1) / kOuterWall;
    if (recess_end > kPi - 0.1) {
      continue;
    }
    corners.push_back(on_end(side, kOuterWall, recess));
    corners.push_back(on_end(side, kOuterWall + depth, recess));
    corners.push_back(on_end(side, kOuterWall + depth, recess_end));
    turn = recess_end;
  }
  corners.push_back(on_end(side, kOuterWall, kPi));
  return corners;
}

/// A straight side: the corridor along it, and the rooms behind its wall.
struct Side {
  std::vector<Room> rooms;
  std::vector<Room> visited;
};

/// @param sign  of y: 1 for the upper side.
Side draw_side(double sign, Random& random) {
  Room shape;
  shape.left = -kStraightHalfLength;
  shape.right = kStraightHalfLength;
  shape.near_y = sign * (kOuterWall + 0.5 * kWallThickness);
  shape.far_y = sign * (kOuterWall + kRoomDepth);
  Side side;
  side.rooms = draw_room_row(shape, kRoomsInRow, random);
  side.visited = draw_visited(side.rooms, kVisitedInRow, random);
  return side;
}

/// Once around, counter-clockwise, with visits to rooms.
Route draw_route(const Side& lower, const Side& upper, Random& random) {
  constexpr double kStep = degrees_to_radians(15.0);
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  append_end(-1.0, kMiddle, kStep, route.waypoints);
  for (const Room& room : lower.visited) {
    visit_room(room, -kMiddle, random, route.waypoints);
  }
  append_end(1.0, kMiddle, kStep, route.waypoints);
  for (auto room = upper.visited.rbegin(); room != upper.visited.rend(); ++room) {
    visit_room(*room, kMiddle, random, route.waypoints);
  }
  route.waypoints.push_back(route.waypoints.front());
  return route;
}

void add_side(const Side& side, Random& random, FloorPlan& plan) {
  const double near_y = side.rooms.front().near_y;
  const double far_y = side.rooms.front().far_y;
  std::vector<double> doors;
  for (const Room& room : side.rooms) {
    doors.push_back(room.door_x + kStraightHalfLength);
  }
  plan.add_wall({-kStraightHalfLength, near_y}, {kStraightHalfLength, near_y}, kWallThickness,
                doors, kDoorWidth);
  plan.add_wall({-kStraightHalfLength, far_y}, {kStraightHalfLength, far_y}, kWallThickness);
  plan.add_wall({-kStraightHalfLength, near_y}, {-kStraightHalfLength, far_y}, kWallThickness);
  for (const Room& room : side.rooms) {
    plan.add_wall({room.right, near_y}, {room.right, far_y}, kWallThickness);
    furnish_room(room, kDoorWidth, random, plan);
  }
}

/// Half pillars that stand out of the outer wall, where they are in nobody's way.
void add_pillars(Random& random, FloorPlan& plan) {
  constexpr int kCorners = 12;
  constexpr double kGap = 0.6;
  for (int i = 0; i < 8; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const Eigen::Vector2d centre = on_end(side, kOuterWall, random.uniform(0.1, kPi - 0.1));
    plan.add_if_clear(outline(regular_polygon(centre, random.uniform(0.15, 0.3), kCorners, 0.0)),
                      kClearance, kGap);
  }
}

/// What stands in the atrium, beyond the railing: a lift and columns.
void fill_atrium(Random& random, FloorPlan& plan) {
  constexpr double kGap = 1.0;
  const double lift_x = random.uniform(-4.0, 4.0);
  plan.add_if_clear(outline(box({lift_x, random.uniform(-1.5, 1.5)}, {2.2, 1.8}, 0.0)), kClearance,
                    kGap);
  for (int i = 0; i < 6; ++i) {
    const double x = random.uniform(-kStraightHalfLength, kStraightHalfLength);
    const Eigen::Vector2d centre(x, random.uniform(-3.5, 3.5));
    plan.add_if_clear(outline(regular_polygon(centre, random.uniform(0.2, 0.35), 16, 0.0)),
                      kClearance, kGap);
  }
}

}  // namespace

World make_atrium_world(std::uint64_t seed) {
  Random random(seed);
  const Side lower = draw_side(-1.0, random);
  const Side upper = draw_side(1.0, random);
  FloorPlan plan(draw_route(lower, upper, random));
  plan.add(with_surface(outline(stadium(kRailing)), railing()));
  plan.add(open_line(draw_round_wall(1.0, random)));
  plan.add(open_line(draw_round_wall(-1.0, random)));
  add_side(lower, random, plan);
  add_side(upper, random, plan);
  add_pillars(random, plan);
  fill_atrium(random, plan);
  return plan.world(seed);
}

}  // namespace matchbox_slam
