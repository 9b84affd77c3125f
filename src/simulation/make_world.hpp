#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simulation/world.hpp"

namespace matchbox_slam {

/// A building of about 22 m x 20 m: a corridor with furnished rooms on both sides, doors to the
/// corridor and between some rooms. The route tours all rooms and ends where it started.
[[nodiscard]] World make_rooms_world(std::uint64_t seed);

/// Chaotic clutter of short segments and small polygons over 20 m x 20 m, ringed by denser clutter;
/// no straight line is longer than 0.6 m. The route is a lap around the middle.
[[nodiscard]] World make_random_world(std::uint64_t seed);

/// A straight, featureless corridor of 120 m along the x axis. The route runs 50 m along its middle
/// and keeps more than 30 m from both ends, so that a scan cannot tell where along the corridor it
/// is.
[[nodiscard]] World make_corridor_world(std::uint64_t seed);

/// A square ring corridor, 100 m along its middle and 2.2 m wide, with doors, niches, pillars,
/// cabinets and radiators at irregular places. The route is one lap and 16 m of the next.
[[nodiscard]] World make_loop_world(std::uint64_t seed);

/// A campus of 250 m x 125 m: five buildings of corridors in nested loops and a courtyard with
/// trees, joined by plain corridors, 1.9 km of them. All doors and all rooms are equal; what tells
/// one place from another is which doors are open and where a few cabinets stand. The route is a
/// tour of 3 km.
[[nodiscard]] World make_campus_world(std::uint64_t seed);

/// Three equal corridors, joined at both ends, with rows of equal rooms, all doors open: but for
/// the ends nothing tells one from the next. The route passes and visits rooms for about 450 m.
[[nodiscard]] World make_hotel_world(std::uint64_t seed);

/// A ring corridor around an atrium, 72 m along its middle, with a railing to the atrium that lets
/// half of the beams pass, rooms along its straight sides and round walls at its ends. The route is
/// once around, with visits to rooms.
[[nodiscard]] World make_atrium_world(std::uint64_t seed);

/// A corridor of 24 m with rooms on both sides, most of whose walls are panes of glass between
/// posts: a pane returns only beams within 12 degrees of its normal. The route visits rooms and
/// ends where it started.
[[nodiscard]] World make_glass_world(std::uint64_t seed);

/// A street of 46 m: house fronts with gaps, trees, hedges whose returns scatter over 0.3 m of
/// depth, parked cars, and much sky. The route leads out on one side and back on the other.
[[nodiscard]] World make_street_world(std::uint64_t seed);

/// A hall of 48 m x 32 m with thin pillars, tables and chairs of which there are only the legs, and
/// twelve people who walk. The route is a tour that ends where it started.
[[nodiscard]] World make_hall_world(std::uint64_t seed);

/// A warehouse of 44 m x 27 m: five double racks with uprights and pallets, of which three in
/// ten are missing. The route goes through all aisles, 182 m.
[[nodiscard]] World make_warehouse_world(std::uint64_t seed);

/// A garage of 62 m x 32 m: two lanes with parked cars and pillars on both sides. The route leads
/// out along one lane and back along the other.
[[nodiscard]] World make_garage_world(std::uint64_t seed);

/// A park of 54 m x 54 m without any wall: trunks, bushes whose returns scatter over 0.3 m of
/// depth, and benches. The route is a winding path around its middle, of about 95 m.
[[nodiscard]] World make_park_world(std::uint64_t seed);

/// A tunnel through rough rock, 3.4 m wide and about 100 m around. The route is one lap.
[[nodiscard]] World make_mine_world(std::uint64_t seed);

/// A greenhouse of 34 m x 19 m: seven rows of plants, whose returns scatter over 0.25 m of depth
/// and each face of which lets a fifth of the beams pass, with posts at times. The route goes
/// between all rows.
[[nodiscard]] World make_greenhouse_world(std::uint64_t seed);

/// The names that make_world knows.
[[nodiscard]] std::vector<std::string> world_names();

/// The world of that name; the same seed gives the same bits.
/// Throws ConfigurationError for a name that is not among world_names().
[[nodiscard]] World make_world(const std::string& name, std::uint64_t seed);

}  // namespace matchbox_slam
