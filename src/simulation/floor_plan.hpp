#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "simulation/wall_segment.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// Corners in order, counter-clockwise when closed.
using Corners = std::vector<Eigen::Vector2d>;

/// The point in this direction [rad] from the origin, and so far from it.
[[nodiscard]] Eigen::Vector2d polar(double radius, double angle);

/// A rectangle whose sides `size` are turned by `angle` about its centre.
[[nodiscard]] Corners box(const Eigen::Vector2d& centre, const Eigen::Vector2d& size, double angle);

/// A regular polygon, such as a round pillar.
[[nodiscard]] Corners regular_polygon(const Eigen::Vector2d& centre, double radius, int corners,
                                      double angle);

/// The lines that join the corners, without the one from the last to the first.
[[nodiscard]] std::vector<WallSegment> open_line(const Corners& corners);

/// The lines that join the corners, all around.
[[nodiscard]] std::vector<WallSegment> outline(const Corners& corners);

/// The same lines of this surface.
[[nodiscard]] std::vector<WallSegment> with_surface(std::vector<WallSegment> lines,
                                                    const WallSurface& surface);

/// Walls and things in a world that is being drawn.
class FloorPlan {
 public:
  /// @param route  that has to stay free.
  explicit FloorPlan(Route route);

  /// Adds lines, wherever they are.
  void add(const std::vector<WallSegment>& lines);

  /// Adds a wall of two faces with openings for doors, whose middles are at `doors` [m] along it.
  void add_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness,
                std::vector<double> doors = {}, double door_width = 0.0);

  /// Adds a thing of several outlines unless it comes nearer than `clearance` to the route or than
  /// `gap` to a thing added before. Returns whether it was added.
  /// @param hinge  [m] of a door's leaf.
  bool add_if_clear(const std::vector<WallSegment>& lines, double clearance, double gap,
                    const std::optional<Eigen::Vector2d>& hinge = {});

  /// Whether lines come nowhere nearer than `clearance` to the route and than `gap` to a thing.
  [[nodiscard]] bool is_clear(const std::vector<WallSegment>& lines, double clearance,
                              double gap) const;

  /// Adds a thing that goes a way, wherever that leads; the lines are where it is at time 0.
  void add_walking(const std::vector<WallSegment>& lines, const Walk& walk);

  /// @param seed  of what surfaces leave to chance.
  [[nodiscard]] World world(std::uint64_t seed = 0) const {
    return {segments_, route_, walks_, seed, things_};
  }

 private:
  Route route_;
  std::vector<WallSegment> route_lines_;
  std::vector<WallSegment> segments_;
  std::vector<WallSegment> thing_lines_;
  std::vector<Thing> things_;
  std::vector<Walk> walks_;
};

}  // namespace matchbox_slam
