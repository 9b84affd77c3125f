#pragma once

#include <Eigen/Core>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "simulation/corridor_net.hpp"
#include "simulation/solid_plan.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// Corridors along the axes with rows of equal rooms on both sides: metres, in tenths.
struct EqualRooms {
  double corridor_half_width = 1.2;
  double pitch = 4.0;  ///< from one door to the next
  double depth = 4.5;
  double door = 1.2;
  double recess = 0.1;    ///< of doors that are shut
  double wall = 0.2;      ///< thickness
  double open = 1.0;      ///< share of the doors that are
  double cabinets = 0.0;  ///< share of the doors with one beside
  double visits = 0.0;    ///< share of the doors that a drive does not pass but goes in

  /// From the middle of a corridor to the far walls of its rooms.
  [[nodiscard]] double reach() const { return corridor_half_width + wall + depth; }
};

/// The corridor, and a square at both of its ends.
void cut_corridor(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const EqualRooms& rooms,
                  SolidPlan& plan);

/// Rooms behind the doors that are open, recesses where they are shut, away from both ends of the
/// corridor, where others may cross it.
void cut_rooms(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const EqualRooms& rooms,
               Random& random, SolidPlan& plan);

/// A tour of the corridors, swerving a little as a driver does; see CorridorNet::tour.
[[nodiscard]] Route draw_route(const CorridorNet& net, double length, const EqualRooms& rooms,
                               Random& random);

}  // namespace matchbox_slam
