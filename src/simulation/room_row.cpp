#include "simulation/room_row.hpp"

#include <cstddef>

namespace matchbox_slam {
namespace {

constexpr double kDoorApproach = 0.9;  // [m] straight on before and behind a door

}  // namespace

std::vector<Room> draw_room_row(const Room& shape, int count, Random& random) {
  const double mean_width = (shape.right - shape.left) / count;
  std::vector<Room> rooms;
  Room room = shape;
  for (int i = 1; i <= count; ++i) {
    room.right =
        i == count ? shape.right : shape.left + mean_width * (i + random.uniform(-0.12, 0.12));
    const double middle = 0.5 * (room.left + room.right);
    room.door_x = middle + random.uniform(-0.15, 0.15) * mean_width;
    rooms.push_back(room);
    room.left = room.right;
  }
  return rooms;
}

std::vector<Room> draw_visited(const std::vector<Room>& row, std::size_t count, Random& random) {
  std::vector<Room> visited;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto wanted = static_cast<double>(count - visited.size());
    // As likely as it takes to end with so many.
    if (random.uniform() * static_cast<double>(row.size() - i) < wanted) {
      visited.push_back(row[i]);
    }
  }
  return visited;
}

void visit_room(const Room& room, double corridor_y, Random& random, Corners& route) {
  const double inside_door = room.near_y + room.inwards() * kDoorApproach;
  const double x = room.left + random.uniform(0.4, 0.6) * (room.right - room.left);
  const double deep = random.uniform(0.5, 0.65);
  route.emplace_back(room.door_x, corridor_y);
  route.emplace_back(room.door_x, inside_door);
  route.emplace_back(x, room.near_y + deep * (room.far_y - room.near_y));
  route.emplace_back(room.door_x, inside_door);
  route.emplace_back(room.door_x, corridor_y);
}

}  // namespace matchbox_slam
