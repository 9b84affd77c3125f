#pragma once

#include "matchbox_slam/common/random.hpp"
#include "simulation/floor_plan.hpp"

namespace matchbox_slam {

/// One room beside a corridor along x.
struct Room {
  double left = 0.0;    ///< [m], x of the wall
  double right = 0.0;   ///< [m], x of the wall
  double near_y = 0.0;  ///< [m], y of the wall towards the corridor
  double far_y = 0.0;   ///< [m], y of the wall opposite, above or below the near one
  double door_x = 0.0;  ///< [m], middle of the door to the corridor
  bool is_open_to_next = false;
  double next_door_y = 0.0;  ///< [m], middle of the door to the room on the right

  /// Sign of y from the door into the room.
  [[nodiscard]] double inwards() const { return far_y > near_y ? 1.0 : -1.0; }
};

/// Adds an open door leaf, cabinets along the walls, tables on legs, boxes and pillars, out of the
/// way of the route.
void furnish_room(const Room& room, double door_width, Random& random, FloorPlan& plan);

/// Adds cabinets along the walls of a corridor along x, from 0 to `length`.
void furnish_corridor(double length, double middle_y, double half_width, Random& random,
                      FloorPlan& plan);

}  // namespace matchbox_slam
