#include "simulation/world_changes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "simulation/floor_plan.hpp"

namespace matchbox_slam {
namespace {

// All in metres.
constexpr double kClearance = 0.65;      // between the route and what is put elsewhere, or built
constexpr double kLeafClearance = 0.42;  // between the route and a door's leaf
constexpr double kGap = 0.1;             // between one thing and the next
constexpr double kWallClearance = 0.02;  // between a thing and a wall
constexpr int kMaxTries = 200;

using Lines = std::vector<WallSegment>;

/// What stands still, and is none of the things.
Lines walls_of(const World& world) {
  std::vector<bool> is_wall(world.segments().size(), true);
  for (const Thing& thing : world.things()) {
    for (std::size_t i = thing.begin; i < thing.end; ++i) {
      is_wall[i] = false;
    }
  }
  Lines walls;
  for (std::size_t i = 0; i < is_wall.size(); ++i) {
    if (is_wall[i] && !world.segments()[i].surface.walk) {
      walls.push_back(world.segments()[i]);
    }
  }
  return walls;
}

bool keep_off(const Lines& lines, const Lines& walls, double least) {
  return std::all_of(lines.begin(), lines.end(), [&](const WallSegment& line) {
    return std::all_of(walls.begin(), walls.end(),
                       [&](const WallSegment& wall) { return distance(line, wall) >= least; });
  });
}

Eigen::Vector2d centre_of(const Lines& lines) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const WallSegment& line : lines) {
    sum += line.start + line.end;
  }
  return sum / (2.0 * static_cast<double>(lines.size()));
}

/// Turned about a point, and shifted.
Lines displaced(Lines lines, const Eigen::Vector2d& about, double turn,
                const Eigen::Vector2d& shift) {
  const Eigen::Vector2d to = about + shift;
  const Pose2 back{-about.x(), -about.y(), 0.0};
  const Pose2 new_from_old = Pose2{to.x(), to.y(), turn} * back;
  for (WallSegment& line : lines) {
    line.start = new_from_old * line.start;
    line.end = new_from_old * line.end;
  }
  return lines;
}

Lines draw_displaced(const Lines& lines, const std::optional<Eigen::Vector2d>& hinge,
                     Random& random) {
  constexpr double kLeafTurn = 1.0;  // [rad]
  constexpr double kShift = 3.0;     // [m]
  if (hinge) {
    return displaced(lines, *hinge, random.uniform(-kLeafTurn, kLeafTurn), {0.0, 0.0});
  }
  const double x = random.uniform(-kShift, kShift);
  return displaced(lines, centre_of(lines), random.uniform(-kPi, kPi),
                   {x, random.uniform(-kShift, kShift)});
}

/// How its corners go when a thing is put elsewhere, but for those at the hinge, in the wall.
Lines ways_of(const Lines& lines, const Lines& there, const std::optional<Eigen::Vector2d>& hinge) {
  constexpr double kHingeRadius = 0.1;  // [m]
  Lines ways;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (const auto& [from, to] :
         {std::pair(lines[i].start, there[i].start), std::pair(lines[i].end, there[i].end)}) {
      if (!hinge || (from - *hinge).norm() > kHingeRadius) {
        ways.push_back({from, to});
      }
    }
  }
  return ways;
}

/// Where a thing may stand as well, on the same side of all walls.
/// @param others  that are not in the plan.
std::optional<Lines> elsewhere(const Lines& lines, const std::optional<Eigen::Vector2d>& hinge,
                               const Lines& walls, const Lines& others, const FloorPlan& plan,
                               Random& random) {
  for (int i = 0; i < kMaxTries; ++i) {
    Lines there = draw_displaced(lines, hinge, random);
    if (plan.is_clear(there, hinge ? kLeafClearance : kClearance, kGap) &&
        keep_off(there, others, kGap) && keep_off(ways_of(lines, there, hinge), walls, 1e-9) &&
        (hinge || keep_off(there, walls, kWallClearance))) {  // a leaf hangs on a wall
      return there;
    }
  }
  return std::nullopt;
}

/// Whether nothing stands between a place and some way-point.
bool is_seen_from(const Route& route, const Eigen::Vector2d& place, const Lines& walls) {
  return std::any_of(route.waypoints.begin(), route.waypoints.end(),
                     [&](const Eigen::Vector2d& from) {
                       return keep_off({{from, place}}, walls, 1e-9);
                     });
}

/// A wall from another one into the open, which ends before the next one.
std::optional<Lines> draw_wall(const World& world, const Lines& walls, const FloorPlan& plan,
                               Random& random) {
  if (walls.empty()) {  // as in a street
    return std::nullopt;
  }
  constexpr double kThickness = 0.12;
  constexpr double kFoot = 0.35;         // so near it is to the wall that it is built from
  constexpr double kFreeDistance = 0.3;  // to all other walls
  for (int i = 0; i < kMaxTries; ++i) {
    const WallSegment& from = walls[random.next() % walls.size()];
    const Eigen::Vector2d foot = from.start + random.uniform(0.1, 0.9) * (from.end - from.start);
    const Eigen::Vector2d along = random.uniform() < 0.5 ? from.normal() : -from.normal();
    const double length = random.uniform(1.0, 3.0);
    const Eigen::Vector2d middle = foot + 0.5 * length * along;
    const Lines axis = {{foot + kFoot * along, foot + length * along}};
    Lines wall = outline(box(middle, {length, kThickness}, std::atan2(along.y(), along.x())));
    if (keep_off(axis, walls, kFreeDistance) && plan.is_clear(wall, kClearance, kGap) &&
        is_seen_from(world.route(), middle, walls)) {
      return wall;
    }
  }
  return std::nullopt;
}

Lines lines_of(const World& world, const Thing& thing) {
  const auto begin = world.segments().begin();
  return {begin + static_cast<std::ptrdiff_t>(thing.begin),
          begin + static_cast<std::ptrdiff_t>(thing.end)};
}

/// Puts what moves back into a plan.
void add_walkers(const World& world, FloorPlan& plan) {
  for (std::size_t i = 0; i < world.walks().size(); ++i) {
    Lines lines;
    std::copy_if(world.segments().begin(), world.segments().end(), std::back_inserter(lines),
                 [i](const WallSegment& line) { return line.surface.walk == i; });
    plan.add_walking(lines, world.walks()[i]);
  }
}

}  // namespace

ChangedWorld changed(const World& world, const WorldChangeOptions& options) {
  constexpr double kNoClearance = -1.0;  // what stood there stays
  if (!options.any()) {
    return {world};  // with its segments in their order, which chance goes by
  }
  const auto seed = static_cast<std::uint64_t>(options.change_seed);
  Lines walls = walls_of(world);
  FloorPlan plan(world.route());
  plan.add(walls);
  std::vector<std::size_t> to_move;
  std::size_t taken = 0;
  for (std::size_t i = 0; i < world.things().size(); ++i) {
    const double chance = Random(mix_seed(seed, i)).uniform();
    if (chance < options.taken) {
      ++taken;
    } else if (chance < options.taken + options.moved) {
      to_move.push_back(i);
    } else {
      const Thing& thing = world.things()[i];
      plan.add_if_clear(lines_of(world, thing), kNoClearance, kNoClearance, thing.hinge);
    }
  }
  std::size_t moved = 0;
  for (auto at = to_move.begin(); at != to_move.end(); ++at) {
    Random random(mix_seed(~seed, *at));
    const Thing& thing = world.things()[*at];
    const Lines lines = lines_of(world, thing);
    Lines others;  // which stay where they stand if they find no other place
    std::for_each(at + 1, to_move.end(), [&](std::size_t other) {
      const Lines standing = lines_of(world, world.things()[other]);
      others.insert(others.end(), standing.begin(), standing.end());
    });
    const std::optional<Lines> there = elsewhere(lines, thing.hinge, walls, others, plan, random);
    moved += there ? 1 : 0;
    plan.add_if_clear(there.value_or(lines), kNoClearance, kNoClearance, thing.hinge);
  }
  Random random(mix_seed(seed, ~std::uint64_t{0}));
  std::size_t built = 0;
  for (int i = 0; i < options.walls; ++i) {
    if (const std::optional<Lines> wall = draw_wall(world, walls, plan, random)) {
      ++built;
      plan.add(*wall);
      walls.insert(walls.end(), wall->begin(), wall->end());
    }
  }
  add_walkers(world, plan);
  return {plan.world(world.seed()), moved, taken, built};
}

}  // namespace matchbox_slam
