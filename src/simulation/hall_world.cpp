#include <cmath>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "simulation/floor_plan.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

// All in metres. The hall's lower left corner is the origin.
constexpr double kLength = 48.0;
constexpr double kWidth = 32.0;
constexpr double kPillarSpacing = 7.0;
constexpr double kClearance = 0.65;  // between the route and what stands in the hall
constexpr double kGap = 0.3;         // between one thing and the next
constexpr int kTables = 26;          // that are tried; a few stand in the way
constexpr int kPeople = 12;
constexpr double kPersonRadius = 0.25;
constexpr double kPersonClearance = 0.5;  // between a person and the route, or a thing

/// Around in the hall, with a bend into its middle.
Route draw_route(Random& random) {
  const Corners way = {{7.0, 6.0},   {24.0, 5.5},  {41.0, 6.0},  {42.0, 16.0}, {41.0, 26.0},
                       {30.0, 26.0}, {25.0, 17.0}, {18.0, 26.0}, {7.0, 26.0},  {6.0, 16.0}};
  Route route;
  route.start_heading = random.uniform(-0.5, 0.5);
  for (const Eigen::Vector2d& point : way) {
    const double off = random.uniform(0.0, 1.0);
    route.waypoints.emplace_back(point + polar(off, random.uniform(-kPi, kPi)));
  }
  route.waypoints.push_back(route.waypoints.front());
  return route;
}

/// The walls, with doors, shut, in their recesses.
Corners draw_walls(Random& random) {
  const Corners corners = box({0.5 * kLength, 0.5 * kWidth}, {kLength, kWidth}, 0.0);
  Corners walls;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& from = corners[i];
    const Eigen::Vector2d way = corners[(i + 1) % corners.size()] - from;
    const Eigen::Vector2d along = way.normalized();
    const Eigen::Vector2d outwards(along.y(), -along.x());
    walls.push_back(from);
    double at = random.uniform(1.0, 8.0);
    while (at < way.norm() - 3.0) {
      const double end = at + random.uniform(1.0, 2.2);
      const double depth = random.uniform(0.1, 0.4);
      walls.emplace_back(from + at * along);
      walls.emplace_back(from + at * along + depth * outwards);
      walls.emplace_back(from + end * along + depth * outwards);
      walls.emplace_back(from + end * along);
      at = end + random.uniform(2.0, 12.0);
    }
  }
  return walls;
}

void add_pillars(Random& random, FloorPlan& plan) {
  constexpr int kCorners = 12;
  constexpr double kMaxShift = 0.4;
  for (double x = 0.5 * kPillarSpacing; x < kLength; x += kPillarSpacing) {
    for (double y = 0.5 * kPillarSpacing; y < kWidth; y += kPillarSpacing) {
      const double off_x = random.uniform(-kMaxShift, kMaxShift);
      const Eigen::Vector2d centre(x + off_x, y + random.uniform(-kMaxShift, kMaxShift));
      plan.add_if_clear(outline(regular_polygon(centre, random.uniform(0.08, 0.15), kCorners, 0.0)),
                        kClearance, kGap);
    }
  }
}

/// The four legs of a table or chair, which are all of it that a laser sees.
void append_legs(const Eigen::Vector2d& centre, const Eigen::Vector2d& size, double leg,
                 double angle, std::vector<WallSegment>& lines) {
  for (const Eigen::Vector2d& corner : box(centre, size, angle)) {
    for (WallSegment line : outline(box(corner, {leg, leg}, angle))) {
      line.is_table = true;
      lines.push_back(line);
    }
  }
}

/// A table with four chairs, as somebody left them.
void add_table(Random& random, FloorPlan& plan) {
  const double x = random.uniform(1.5, kLength - 1.5);
  const Eigen::Vector2d centre(x, random.uniform(1.5, kWidth - 1.5));
  const double angle = random.uniform(-kPi, kPi);
  std::vector<WallSegment> legs;
  append_legs(centre, {1.5, 0.8}, 0.05, angle, legs);
  for (int i = 0; i < 4; ++i) {
    const double side = angle + 0.5 * kPi * (i % 2 == 0 ? 1.0 : -1.0);
    const double along = (i < 2 ? 0.4 : -0.4) + random.uniform(-0.1, 0.1);
    const Eigen::Vector2d at =
        centre + polar(along, angle) + polar(random.uniform(0.75, 1.1), side);
    append_legs(at, {0.4, 0.4}, 0.03, angle + random.uniform(-0.6, 0.6), legs);
  }
  plan.add_if_clear(legs, kClearance, kGap);
}

/// A way around three corners.
Corners draw_way(Random& random) {
  const double x = random.uniform(3.0, kLength - 3.0);
  const Eigen::Vector2d middle(x, random.uniform(3.0, kWidth - 3.0));
  const double first = random.uniform(-kPi, kPi);
  Corners way;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d corner =
        middle + polar(random.uniform(1.0, 5.0), first + 2.0 * kPi * i / 3.0);
    way.emplace_back(corner.cwiseMax(1.0).cwiseMin(Eigen::Vector2d(kLength - 1.0, kWidth - 1.0)));
  }
  return way;
}

/// People who walk for ever, clear of the route and of all things, but not of each other.
void add_people(Random& random, FloorPlan& plan) {
  constexpr int kCorners = 12;
  constexpr double kPersonMargin = kPersonRadius + kPersonClearance;
  for (int people = 0; people < kPeople;) {
    const Corners way = draw_way(random);
    const double speed = random.uniform(0.6, 1.5);
    const Walk walk(way, speed, random.uniform(0.0, 10.0));
    if (plan.is_clear(outline(way), kPersonMargin, kPersonMargin)) {
      plan.add_walking(outline(regular_polygon(walk.at(0.0), kPersonRadius, kCorners, 0.0)), walk);
      ++people;
    }
  }
}

}  // namespace

World make_hall_world(std::uint64_t seed) {
  Random random(seed);
  FloorPlan plan(draw_route(random));
  plan.add(outline(draw_walls(random)));
  add_pillars(random, plan);
  for (int i = 0; i < kTables; ++i) {
    add_table(random, plan);
  }
  add_people(random, plan);
  return plan.world(seed);
}

}  // namespace matchbox_slam
