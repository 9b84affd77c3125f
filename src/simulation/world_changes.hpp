#pragma once

#include <cstddef>

#include "matchbox_slam/common/options.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// What people change in a building from one day to another.
struct WorldChangeOptions {
  double moved = 0.0;
  double taken = 0.0;
  int walls = 0;
  int change_seed = 1;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(
        self.moved, "moved", between(0.0, 1.0), "",
        "Share of the things beside the walls, furniture and pillars, that stand elsewhere, up to "
        "3 m off and turned, and of the doors' leaves that stand open otherwise; each by chance.");
    option(self.taken, "taken", between(0.0, 1.0), "",
           "Share of the things that are gone; each by chance.");
    option(self.walls, "walls", between(0, 1000), "",
           "So many walls of 1 to 3 m are built from another one into the open.");
    option(self.change_seed, "change_seed", at_least(0), "",
           "Of these changes: another day in the same world.");
  }

  [[nodiscard]] bool any() const { return moved > 0.0 || taken > 0.0 || walls > 0; }
};

/// A world on another day, and how many changes there are: less than were asked for where there is
/// no room that leaves the route free.
struct ChangedWorld {
  World world;
  std::size_t moved = 0;
  std::size_t taken = 0;
  std::size_t built = 0;  ///< walls
};

/// The same world and options give the same bits. The route stays as it is; people walk on where
/// they walked, through what stands there now.
[[nodiscard]] ChangedWorld changed(const World& world, const WorldChangeOptions& options);

}  // namespace matchbox_slam
