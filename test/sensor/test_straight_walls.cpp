#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "sensor/straight_walls.hpp"

namespace matchbox_slam {
namespace {

constexpr double kGap = 2.0;

/// What a laser at the origin measures when the range in each direction is this.
std::vector<ScanPoint> measured(const std::function<double(double)>& range, double noise,
                                std::uint64_t seed = 1, std::size_t beams = 1040) {
  Random random(seed);
  std::vector<ScanPoint> points(beams);
  for (std::size_t i = 0; i < beams; ++i) {
    const double angle = -2.25 + 4.5 * (static_cast<double>(i) + 0.5) / static_cast<double>(beams);
    points[i].position = (range(angle) + noise * random.gaussian()) *
                         Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  return points;
}

/// A room with walls at x = -3 and 4, y = -2 and 5.
double range_in_room(double angle) {
  const double x = std::cos(angle);
  const double y = std::sin(angle);
  return std::min(x > 0.0 ? 4.0 / x : -3.0 / x, y > 0.0 ? 5.0 / y : -2.0 / y);
}

double off_room(const Eigen::Vector2d& point) {
  return std::min(std::min(std::abs(point.x() + 3.0), std::abs(point.x() - 4.0)),
                  std::min(std::abs(point.y() + 2.0), std::abs(point.y() - 5.0)));
}

double root_mean_square(const std::vector<ScanPoint>& points,
                        const std::function<double(const Eigen::Vector2d&)>& error) {
  double sum = 0.0;
  for (const ScanPoint& point : points) {
    sum += error(point.position) * error(point.position);
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

TEST(RangeNoise, IsWhatTheRangesHave) {
  for (const double noise : {0.003, 0.01, 0.03}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      EXPECT_NEAR(range_noise({measured(range_in_room, noise, seed), kGap}), noise, 0.1 * noise);
    }
  }
  EXPECT_LT(range_noise({measured(range_in_room, 0.0), kGap}), 1e-9);
}

TEST(RangeNoise, IsNotMistakenForCornersAndEdges) {
  const auto pillars = [](double angle) {
    return range_in_room(angle) - (std::sin(40.0 * angle) > 0.5 ? 0.7 : 0.0);
  };
  for (const double noise : {0.003, 0.01, 0.03}) {
    EXPECT_NEAR(range_noise({measured(pillars, noise), kGap}), noise, 0.2 * noise);
  }
}

TEST(RangeNoise, IsNoneWhereNothingTellsIt) {
  EXPECT_EQ(range_noise({{}, kGap}), 0.0);
  EXPECT_EQ(range_noise({std::vector<ScanPoint>(1), kGap}), 0.0);
  std::vector<ScanPoint> coincident(100);
  for (ScanPoint& point : coincident) {
    point.position = {1.0, 2.0};
  }
  EXPECT_EQ(range_noise({coincident, kGap}), 0.0);
}

TEST(StraightenWalls, PutsHitsWhereTheWallsAre) {
  std::vector<ScanPoint> points = measured(range_in_room, 0.01);
  const double before = root_mean_square(points, off_room);
  straighten_walls({points, kGap}, 0.01, points);
  // Four walls of some 260 hits: the root of 2 / 260 is 0.09.
  EXPECT_LT(root_mean_square(points, off_room), 0.2 * before);
  for (const ScanPoint& point : points) {
    // One in a thousand is that far off that it is thought to be something else.
    EXPECT_LT(off_room(point.position), point.moved != 0.0 ? 0.01 : 0.05);
  }
}

TEST(StraightenWalls, KeepsCornersSharp) {
  std::vector<ScanPoint> points = measured(range_in_room, 0.01);
  straighten_walls({points, kGap}, 0.01, points);
  std::size_t near_corner = 0;
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d from_corner = Eigen::Vector2d(4.0, 5.0) - point.position;
    if (from_corner.norm() < 0.3 && from_corner.norm() > 0.04) {
      ++near_corner;
      const bool on_right = from_corner.x() < from_corner.y();
      EXPECT_GT(
          point.normal.dot(on_right ? Eigen::Vector2d(-1.0, 0.0) : Eigen::Vector2d(0.0, -1.0)),
          0.9999);
    }
  }
  EXPECT_GT(near_corner, 8U);
}

TEST(StraightenWalls, MovesHitsAlongTheirBeamsAndSaysHowFar) {
  const std::vector<ScanPoint> before = measured(range_in_room, 0.01);
  std::vector<ScanPoint> points = before;
  straighten_walls({points, kGap}, 0.01, points);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d step = points[i].position - before[i].position;
    EXPECT_LT((step - points[i].moved * before[i].position.normalized()).norm(), 1e-12);
    EXPECT_LE(std::abs(points[i].moved), 0.035);
    EXPECT_NEAR(points[i].normal.norm(), points[i].moved == 0.0 ? 0.0 : 1.0, 1e-12);
    EXPECT_LE(points[i].normal.dot(points[i].position), 0.0);
    moved += points[i].moved != 0.0 ? 1 : 0;
  }
  EXPECT_GT(moved, 1000U);
}

/// A robot in a corridor must not see its walls bend.
TEST(StraightenWalls, LongWallsStayStraight) {
  const auto corridor = [](double angle) {
    return 1.0 / std::max(std::abs(std::sin(angle)), 1.0 / 30.0);
  };
  std::vector<ScanPoint> points = measured(corridor, 0.01);
  straighten_walls({points, kGap}, 0.01, points);
  std::size_t on_wall = 0;
  for (const ScanPoint& point : points) {
    if (!point.normal.isZero() && point.position.norm() < 8.0) {
      ++on_wall;
      EXPECT_LT(std::abs(point.normal.x()), 0.003);
      EXPECT_LT(std::abs(std::abs(point.position.y()) - 1.0), 0.003);
    }
  }
  EXPECT_GT(on_wall, 900U);
}

TEST(StraightenWalls, DoesNotFlattenWhatIsRound) {
  for (const double radius : {0.3, 1.0, 3.0, 10.0}) {
    for (const double noise : {0.001, 0.003, 0.01, 0.03}) {
      std::vector<ScanPoint> points = measured([radius](double) { return radius; }, noise);
      const auto off = [radius](const Eigen::Vector2d& point) { return point.norm() - radius; };
      const double before = root_mean_square(points, off);
      straighten_walls({points, kGap}, noise, points);
      EXPECT_LT(root_mean_square(points, off), 0.9 * before) << radius << ' ' << noise;
    }
  }
}

TEST(StraightenWalls, LeavesAPostInFrontOfAWallAlone) {
  const auto with_post = [](double angle) {
    return range_in_room(angle) - (std::abs(angle - 0.3) < 0.012 ? 0.1 : 0.0);
  };
  std::vector<ScanPoint> points = measured(with_post, 0.01);
  const std::vector<ScanPoint> before = points;
  straighten_walls({points, kGap}, 0.01, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double angle = std::atan2(before[i].position.y(), before[i].position.x());
    EXPECT_NEAR(points[i].position.norm(), with_post(angle), 0.04) << i;
  }
}

TEST(StraightenWalls, LeavesADotAlone) {
  std::vector<ScanPoint> points(50);
  for (ScanPoint& point : points) {
    point.position = {1.0, 2.0};
  }
  straighten_walls({points, kGap}, 0.01, points);
  // And hits one behind the other on one beam, as after a sweep of no width.
  for (std::size_t i = 0; i < 50; ++i) {
    points.emplace_back();
    points.back().position =
        Eigen::Vector2d(0.01 * static_cast<double>(i), 0.02 * static_cast<double>(i));
  }
  straighten_walls({points, kGap}, 0.01, points);
  for (const ScanPoint& point : points) {
    EXPECT_TRUE(point.position.allFinite());
    EXPECT_EQ(point.moved, 0.0);
    EXPECT_TRUE(point.normal.isZero());
  }
}

TEST(StraightenWalls, FewHitsAreNoWall) {
  for (std::size_t count = 0; count < 3; ++count) {
    std::vector<ScanPoint> points = measured(range_in_room, 0.01, 1, count);
    straighten_walls({points, kGap}, 0.01, points);
    for (const ScanPoint& point : points) {
      EXPECT_EQ(point.moved, 0.0);
    }
  }
}

TEST(StraightenWalls, AMirroredScanGivesTheMirroredWalls) {
  std::vector<ScanPoint> points = measured(range_in_room, 0.01);
  std::vector<ScanPoint> mirrored = points;
  for (ScanPoint& point : mirrored) {
    point.position.y() = -point.position.y();
  }
  straighten_walls({points, kGap}, 0.01, points);
  straighten_walls({mirrored, kGap}, 0.01, mirrored);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(mirrored[i].position.x(), points[i].position.x(), 1e-12);
    EXPECT_NEAR(mirrored[i].position.y(), -points[i].position.y(), 1e-12);
    EXPECT_NEAR(mirrored[i].normal.y(), -points[i].normal.y(), 1e-12);
  }
}

TEST(StraightenWalls, AHundredThousandHitsOnOneWallAreFine) {
  std::vector<ScanPoint> points =
      measured([](double angle) { return 2.0 / std::cos(0.3 * angle); }, 0.01, 1, 100000);
  straighten_walls({points, kGap}, 0.01, points);
  for (const ScanPoint& point : points) {
    ASSERT_TRUE(point.position.allFinite());
    ASSERT_LE(std::abs(point.moved), 0.035);
  }
}

}  // namespace
}  // namespace matchbox_slam
