#include "matchbox_slam/common/random.hpp"
#include "simulation/corridor_net.hpp"
#include "simulation/equal_rooms.hpp"
#include "simulation/make_world.hpp"
#include "simulation/solid_plan.hpp"

namespace matchbox_slam {
namespace {

// All in metres, and in tenths of them.
constexpr int kColumns = 3;  // of buildings
constexpr int kRows = 2;
constexpr double kLength = 64.0;  // of a building, between the middles of its outer corridors
constexpr double kDepth = 44.0;
constexpr double kSpacing = 20.0;  // from one to the next
constexpr double kMargin = 8.0;    // around them all
constexpr double kTour = 2900.0;   // and the way home

/// Two ways that cross where the middles of a building's sides are, in halves.
template <typename Add>
void add_cross(const Eigen::Vector2d& corner, Add&& add) {
  const Eigen::Vector2d middle = corner + 0.5 * Eigen::Vector2d(kLength, kDepth);
  for (const Eigen::Vector2d& arm :
       {Eigen::Vector2d(0.5 * kLength, 0.0), Eigen::Vector2d(0.0, 0.5 * kDepth)}) {
    add(middle - arm, middle);
    add(middle, middle + arm);
  }
}

/// Around a building, each side in halves.
template <typename Add>
void add_ring(const Eigen::Vector2d& corner, Add&& add) {
  for (const double part : {0.0, 0.5}) {
    for (const double side : {0.0, 1.0}) {
      const Eigen::Vector2d low = corner + Eigen::Vector2d(part * kLength, side * kDepth);
      const Eigen::Vector2d left = corner + Eigen::Vector2d(side * kLength, part * kDepth);
      add(low, low + Eigen::Vector2d(0.5 * kLength, 0.0));
      add(left, left + Eigen::Vector2d(0.0, 0.5 * kDepth));
    }
  }
}

/// Open to all four sides, with trees off the ways.
void cut_courtyard(const Eigen::Vector2d& corner, Random& random, SolidPlan& plan) {
  constexpr int kTrees = 30;
  constexpr double kTreeClearance = 1.5;
  const Eigen::Vector2d size(kLength, kDepth);
  plan.cut(corner, corner + size);
  for (int i = 0; i < kTrees; ++i) {
    const double thickness = random.uniform(0.3, 0.8);
    const double x = random.uniform(2.0, kLength - 2.0);
    const Eigen::Vector2d tree(x, random.uniform(2.0, kDepth - 2.0));
    if ((tree - 0.5 * size).cwiseAbs().minCoeff() > kTreeClearance) {
      plan.fill(corner + tree, corner + tree + Eigen::Vector2d::Constant(thickness));
    }
  }
}

}  // namespace

World make_campus_world(std::uint64_t seed) {
  Random random(seed);
  EqualRooms rooms;
  rooms.open = 0.25;
  rooms.cabinets = 0.15;
  SolidPlan plan({kColumns * (kLength + kSpacing) - kSpacing + 2.0 * kMargin,
                  kRows * (kDepth + kSpacing) - kSpacing + 2.0 * kMargin});
  CorridorNet net;
  const auto link = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    net.add(from, to);
    cut_corridor(from, to, rooms, plan);
  };
  const auto with_rooms = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    link(from, to);
    cut_rooms(from, to, rooms, random, plan);
  };
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d corner(kMargin + column * (kLength + kSpacing),
                                   kMargin + row * (kDepth + kSpacing));
      if (row == 0 && column == 1) {
        cut_courtyard(corner, random, plan);
        add_cross(corner, link);
      } else {
        add_ring(corner, with_rooms);
        add_cross(corner, with_rooms);
      }
      const Eigen::Vector2d right = corner + Eigen::Vector2d(kLength, 0.5 * kDepth);
      const Eigen::Vector2d top = corner + Eigen::Vector2d(0.5 * kLength, kDepth);
      if (column + 1 < kColumns) {
        link(right, right + Eigen::Vector2d(kSpacing, 0.0));
      }
      if (row + 1 < kRows) {
        link(top, top + Eigen::Vector2d(0.0, kSpacing));
      }
    }
  }
  return {plan.walls(), draw_route(net, kTour, rooms, random)};
}

}  // namespace matchbox_slam
