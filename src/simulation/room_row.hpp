#pragma once

#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/room_furniture.hpp"

namespace matchbox_slam {

/// Rooms side by side along x, each with a door to the corridor somewhere in its middle.
/// @param shape  left and right end of the row, and both walls along it.
[[nodiscard]] std::vector<Room> draw_room_row(const Room& shape, int count, Random& random);

/// The rooms of the row that a route visits, in the order of the row.
[[nodiscard]] std::vector<Room> draw_visited(const std::vector<Room>& row, std::size_t count,
                                             Random& random);

/// Leads the route from the middle of the corridor into a room, to a place there, and back.
/// @param corridor_y  [m], the middle of the corridor.
void visit_room(const Room& room, double corridor_y, Random& random, Corners& route);

}  // namespace matchbox_slam
