#include "simulation/room_furniture.hpp"

#include <cmath>
#include <vector>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

// All in metres.
constexpr double kClearance = 0.65;      // between the route and furniture
constexpr double kLeafClearance = 0.42;  // between the route and an open door's leaf
constexpr double kGap = 0.1;             // between one thing and the next
constexpr double kHalfWall = 0.08;

int draw_count(int low, int high, Random& random) {
  return low + static_cast<int>(random.uniform(0.0, high - low + 1.0));
}

void append(std::vector<WallSegment>& lines, const std::vector<WallSegment>& more) {
  lines.insert(lines.end(), more.begin(), more.end());
}

std::vector<WallSegment> low(std::vector<WallSegment> lines) {
  for (WallSegment& line : lines) {
    line.is_table = true;
  }
  return lines;
}

/// A leaf that hangs on one jamb and opens into the room.
void add_door_leaf(const Room& room, double door_width, Random& random, FloorPlan& plan) {
  constexpr double kThickness = 0.04;
  const double hinge_side = random.uniform() < 0.5 ? -1.0 : 1.0;
  const double open = degrees_to_radians(random.uniform(88.0, 150.0));
  const Eigen::Vector2d hinge(room.door_x + hinge_side * (0.5 * door_width + kThickness),
                              room.near_y + room.inwards() * kHalfWall);
  // Shut, the leaf points from the hinge to the other jamb.
  const Eigen::Vector2d along(-hinge_side * std::cos(open), room.inwards() * std::sin(open));
  const double length = door_width - 0.1;
  plan.add_if_clear(outline(box(hinge + 0.5 * length * along, {length, kThickness},
                                std::atan2(along.y(), along.x()))),
                    kLeafClearance, 0.0, hinge);
}

/// A cabinet, bed or desk with its back to the left, right or far wall.
void add_at_wall(const Room& room, Random& random, FloorPlan& plan) {
  const double length = random.uniform(0.6, 1.9);
  const double depth = random.uniform(0.35, 0.7);
  const double from_wall = kHalfWall + 0.5 * depth + random.uniform(0.0, 0.04);
  const double place = random.uniform(0.1, 0.9);
  const double wall = random.uniform();
  Eigen::Vector2d centre(room.left + place * (room.right - room.left),
                         room.near_y + place * (room.far_y - room.near_y));
  Eigen::Vector2d size(depth, length);
  if (wall < 0.3) {
    centre.x() = room.left + from_wall;
  } else if (wall < 0.6) {
    centre.x() = room.right - from_wall;
  } else {
    // Half a wall's thickness less: the outer walls are plain lines.
    centre.y() = room.far_y - room.inwards() * (from_wall - kHalfWall);
    size = {length, depth};
  }
  plan.add_if_clear(outline(box(centre, size, 0.0)), kClearance, kGap);
}

Eigen::Vector2d draw_place(const Room& room, Random& random) {
  constexpr double kRoomClearance = 1.0;
  const double x = random.uniform(room.left + kRoomClearance, room.right - kRoomClearance);
  const double y = random.uniform(room.near_y + room.inwards() * kRoomClearance,
                                  room.far_y - room.inwards() * kRoomClearance);
  return {x, y};
}

/// At the height of the laser a table is its four legs.
void add_table(const Room& room, Random& random, FloorPlan& plan) {
  const Eigen::Vector2d centre = draw_place(room, random);
  const double length = random.uniform(1.1, 1.8);
  const double depth = random.uniform(0.7, 0.9);
  const double angle = random.uniform(-kPi, kPi);
  std::vector<WallSegment> legs;
  for (const Eigen::Vector2d& corner : box(centre, {length, depth}, angle)) {
    append(legs, low(outline(box(corner, {0.06, 0.06}, angle))));
  }
  plan.add_if_clear(legs, kClearance, kGap);
}

void add_box(const Room& room, Random& random, FloorPlan& plan) {
  const Eigen::Vector2d centre = draw_place(room, random);
  const double length = random.uniform(0.3, 1.0);
  const double depth = random.uniform(0.3, 0.7);
  plan.add_if_clear(low(outline(box(centre, {length, depth}, random.uniform(-kPi, kPi)))),
                    kClearance, kGap);
}

void add_pillar(const Room& room, Random& random, FloorPlan& plan) {
  constexpr int kCorners = 16;
  const Eigen::Vector2d centre = draw_place(room, random);
  plan.add_if_clear(outline(regular_polygon(centre, random.uniform(0.12, 0.25), kCorners, 0.0)),
                    kClearance, kGap);
}

}  // namespace

void furnish_room(const Room& room, double door_width, Random& random, FloorPlan& plan) {
  add_door_leaf(room, door_width, random, plan);
  for (int i = draw_count(8, 14, random); i > 0; --i) {
    add_at_wall(room, random, plan);
  }
  for (int i = draw_count(3, 6, random); i > 0; --i) {
    add_table(room, random, plan);
  }
  for (int i = draw_count(2, 5, random); i > 0; --i) {
    add_box(room, random, plan);
  }
  for (int i = draw_count(1, 3, random); i > 0; --i) {
    add_pillar(room, random, plan);
  }
}

void furnish_corridor(double length, double middle_y, double half_width, Random& random,
                      FloorPlan& plan) {
  for (int i = draw_count(4, 7, random); i > 0; --i) {
    const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
    const double cabinet_length = random.uniform(0.6, 1.5);
    const double depth = random.uniform(0.15, 0.33);
    const double x = random.uniform(1.0, length - 1.0);
    const double y = middle_y + side * (half_width - kHalfWall - 0.5 * depth);
    plan.add_if_clear(outline(box({x, y}, {cabinet_length, depth}, 0.0)), kClearance, kGap);
  }
}

}  // namespace matchbox_slam
