#include "simulation/make_world.hpp"

#include <array>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

struct NamedWorld {
  const char* name;
  World (*make)(std::uint64_t seed);
};

constexpr std::array<NamedWorld, 15> kWorlds = {{{"rooms", make_rooms_world},
                                                 {"random", make_random_world},
                                                 {"corridor", make_corridor_world},
                                                 {"loop", make_loop_world},
                                                 {"campus", make_campus_world},
                                                 {"hotel", make_hotel_world},
                                                 {"atrium", make_atrium_world},
                                                 {"glass", make_glass_world},
                                                 {"street", make_street_world},
                                                 {"hall", make_hall_world},
                                                 {"warehouse", make_warehouse_world},
                                                 {"garage", make_garage_world},
                                                 {"park", make_park_world},
                                                 {"mine", make_mine_world},
                                                 {"greenhouse", make_greenhouse_world}}};

}  // namespace

std::vector<std::string> world_names() {
  std::vector<std::string> names;
  for (const NamedWorld& world : kWorlds) {
    names.emplace_back(world.name);
  }
  return names;
}

World make_world(const std::string& name, std::uint64_t seed) {
  for (const NamedWorld& world : kWorlds) {
    if (name == world.name) {
      return world.make(seed);
    }
  }
  throw ConfigurationError("unknown world '" + name +
                           "'; allowed: " + one_of(world_names()).text());
}

}  // namespace matchbox_slam
