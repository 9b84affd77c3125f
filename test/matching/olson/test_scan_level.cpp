#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "matchbox_slam/common/random.hpp"
#include "matching/olson/field_window.hpp"
#include "matching/olson/scan_level.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLevelResolution = 0.05;

/// A wall around the base, seen from its inside, and one far piece.
PointArrays scan_of_a_room(int count) {
  Random random(7);
  PointArrays points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count;
    const double range = i < count / 50 ? 60.0 : random.uniform(4.0, 4.02) + std::sin(3.0 * angle);
    points.x.push_back(range * std::cos(angle));
    points.y.push_back(range * std::sin(angle));
    points.weights.push_back(static_cast<std::uint16_t>(1 + i % kMaxSearchWeight));
  }
  return points;
}

SearchLattice lattice_of_turns(int steps_per_cell, int half_theta, double step_theta) {
  SearchLattice lattice;
  lattice.steps_per_cell = steps_per_cell;
  lattice.half_theta = half_theta;
  lattice.step_theta = step_theta;
  return lattice;
}

std::int64_t sum(const std::vector<std::uint16_t>& weights) {
  return std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
}

/// Whether all of a scan's points are, at each rotation of a group, within half the slack of the
/// ones that stand for them, which have their weights.
void expect_stands_for(const PointArrays& points, const ScanLevel& level, double step_theta,
                       double slack) {
  std::size_t next = 0;
  int weight = 0;
  std::int64_t unbounded = 0;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    const auto is_near = [&](std::size_t one) {
      if (one >= level.points.x.size()) {
        return false;
      }
      double farthest = 0.0;
      for (int turn = 0; turn < level.turns; ++turn) {
        const double angle = step_theta * (turn - 0.5 * (level.turns - 1));
        const double x = std::cos(angle) * points.x[i] - std::sin(angle) * points.y[i];
        const double y = std::sin(angle) * points.x[i] + std::cos(angle) * points.y[i];
        farthest = std::max(
            {farthest, std::abs(x - level.points.x[one]), std::abs(y - level.points.y[one])});
      }
      return farthest <= 0.5 * slack * kLevelResolution;
    };
    if (weight > 0 && weight + points.weights[i] <= level.points.weights[next] && is_near(next)) {
      weight += points.weights[i];
    } else if (weight == 0 && is_near(next)) {
      weight = points.weights[i];
    } else {
      ASSERT_EQ(weight, 0) << "point " << i;
      unbounded += std::int64_t{255} * points.weights[i];
    }
    if (next < level.points.weights.size() && weight == level.points.weights[next]) {
      weight = 0;
      ++next;
    }
  }
  EXPECT_EQ(next, level.points.x.size());
  EXPECT_EQ(unbounded, level.unbounded);
}

TEST(ScanLevel, StandsForAllPointsAtAllRotationsOfAGroup) {
  const PointArrays points = scan_of_a_room(1000);
  for (const int steps_per_cell : {1, 2, 5, 16}) {
    SCOPED_TRACE("steps per cell " + std::to_string(steps_per_cell));
    const double step_theta = kLevelResolution / steps_per_cell / 5.0;
    ScanLevels levels;
    levels.assign(points, lattice_of_turns(steps_per_cell, 500, step_theta), kLevelResolution,
                  FieldWindow::kLevels - 1);
    EXPECT_EQ(levels[0].turns, 1);
    EXPECT_EQ(levels[0].points.x, points.x);
    for (int i = 1; i < FieldWindow::kLevels; ++i) {
      SCOPED_TRACE("level " + std::to_string(i));
      expect_stands_for(points, levels[i], step_theta,
                        FieldWindow::kBounds.at(static_cast<std::size_t>(i)).slack);
      EXPECT_EQ(255 * sum(levels[i].points.weights) + levels[i].unbounded,
                255 * sum(points.weights));
      EXPECT_EQ(levels[i].turns % levels[i - 1].turns, 0);
      EXPECT_LE(*std::max_element(levels[i].points.weights.begin(), levels[i].points.weights.end()),
                255);
    }
    EXPECT_GT(levels[3].turns, 3 * steps_per_cell);
    EXPECT_LT(levels[3].points.x.size(), points.x.size() / 4);
    EXPECT_GT(levels[3].unbounded, 0);  // the far piece
  }
}

TEST(ScanLevel, HasOneGroupForOneRotation) {
  const PointArrays points = scan_of_a_room(50);
  ScanLevels levels;
  levels.assign(scan_of_a_room(1000), lattice_of_turns(2, 500, 0.005), kLevelResolution, 3);
  levels.assign(points, lattice_of_turns(2, 0, 0.0), kLevelResolution,
                3);  // nothing of before is left
  for (int i = 0; i < FieldWindow::kLevels; ++i) {
    EXPECT_EQ(levels[i].turns, 1);
    EXPECT_EQ(levels[i].unbounded, 0);
    EXPECT_LE(levels[i].points.x.size(), points.x.size());
  }
}

}  // namespace
}  // namespace matchbox_slam
