// Of sensor/point_scan.hpp: normals, weights and neighbours of points.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "sensor/scan_of_room.hpp"

namespace matchbox_slam {
namespace {

/// Normal of the wall that a point of the room lies on, into the room.
Eigen::Vector2d wall_normal(const Eigen::Vector2d& point) {
  const Eigen::Vector2d low = (point - kLow).cwiseAbs();
  const Eigen::Vector2d high = (kHigh - point).cwiseAbs();
  const double nearest = std::min(low.minCoeff(), high.minCoeff());
  if (low.x() == nearest) {
    return {1.0, 0.0};
  }
  if (low.y() == nearest) {
    return {0.0, 1.0};
  }
  return high.x() == nearest ? Eigen::Vector2d(-1.0, 0.0) : Eigen::Vector2d(0.0, -1.0);
}

TEST(PointScan, NormalsAreThoseOfTheWallsAndCornersStaySharp) {
  for (const double yaw : {0.0, 0.7, 2.0}) {
    LaserScan scan = sweep(1000, 6.2);
    measure(scan, mount(0.0, 0.0, 0.0, 0.0, yaw));
    const PointScan projected = project(scan, plain(), mount(0.0, 0.0, 0.0, 0.0, yaw));
    int unknown = 0;
    for (const ScanPoint& point : projected.points) {
      if (point.normal.isZero()) {
        ++unknown;
        continue;
      }
      EXPECT_NEAR(point.normal.norm(), 1.0, 1e-9);
      EXPECT_GT(point.normal.dot(wall_normal(point.position)), 0.99) << point.position;
    }
    EXPECT_LE(unknown, 20) << "only a few, where two walls meet";
  }
}

TEST(PointScan, WithoutNoiseStraighteningChangesNothing) {
  LaserScan scan = sweep(1040, 4.5);
  measure(scan, Eigen::Isometry3d::Identity());
  ProjectionOptions options = plain();
  const PointScan straightened = project(scan, options);
  options.straighten_walls = false;
  const PointScan plain_scan = project(scan, options);
  ASSERT_EQ(straightened.points.size(), plain_scan.points.size());
  for (std::size_t i = 0; i < plain_scan.points.size(); ++i) {
    EXPECT_EQ(straightened.points[i].position, plain_scan.points[i].position);
    EXPECT_EQ(straightened.points[i].normal, plain_scan.points[i].normal);
  }
}

TEST(PointScan, StraighteningTakesNoiseOutHoweverTheLaserIsMountedUnlessItIsTurnedOff) {
  const Eigen::Isometry3d upside_down = mount(0.3, 0.2, kPi, 0.0, 0.4);
  const Pose2 motion{0.05, 0.01, 0.03};
  LaserScan scan = sweep(1040, 4.5);
  measure(scan, upside_down, motion);
  const PointScan truth = project(scan, plain(), upside_down, motion);
  Random random(1);
  for (float& range : scan.ranges) {
    range += static_cast<float>(0.01 * random.gaussian());
  }
  const auto error = [&](bool straighten) {
    ProjectionOptions options = plain();
    options.straighten_walls = straighten;
    const PointScan noisy = project(scan, options, upside_down, motion);
    double sum = 0.0;
    for (std::size_t i = 0; i < noisy.points.size(); ++i) {
      sum += (noisy.points[i].position - truth.points[i].position).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(noisy.points.size()));
  };
  EXPECT_NEAR(error(false), 0.01, 0.001);
  EXPECT_LT(error(true), 0.003);
}

TEST(PointScan, NormalsWithstandNoise) {
  LaserScan scan = sweep(1000, 6.2);
  measure(scan, Eigen::Isometry3d::Identity());
  Random random(4);
  for (float& range : scan.ranges) {
    range += static_cast<float>(0.01 * random.gaussian());
  }
  const auto count_within = [&](double angle, bool straighten) {
    ProjectionOptions options = plain();
    options.straighten_walls = straighten;
    const PointScan noisy = project(scan, options);
    return std::count_if(noisy.points.begin(), noisy.points.end(), [&](const ScanPoint& point) {
      return point.normal.dot(wall_normal(point.position)) > std::cos(angle);
    });
  };
  EXPECT_GE(count_within(0.3, false), 900);
  EXPECT_GE(count_within(0.03, true), 970);
}

TEST(PointScan, ALonePointHasNoNormal) {
  LaserScan scan = sweep(11, 1.0);
  scan.ranges[2] = 3.0F;
  scan.ranges[8] = 3.0F;
  for (const ScanPoint& point : project(scan).points) {
    EXPECT_TRUE(point.normal.isZero());
    EXPECT_FALSE(point.joined_to_next);
  }
}

TEST(PointScan, WeightsAreLengthsOfWall) {
  ProjectionOptions options = plain();
  options.max_point_weight = 1.0;
  LaserScan scan = sweep(1001, 0.8);
  for (std::size_t k = 0; k < 1001; ++k) {
    scan.ranges[k] = static_cast<float>(2.0 / std::cos(angle_of(scan, k)));
  }
  const PointScan dense = project(scan, options);
  double sum = 0.0;
  for (std::size_t i = 1; i + 1 < dense.points.size(); ++i) {
    const double length =
        0.5 * (dense.points[i + 1].position - dense.points[i - 1].position).norm();
    EXPECT_NEAR(dense.points[i].weight, length, 1e-9);
    sum += dense.points[i].weight;
  }
  EXPECT_NEAR(sum, 4.0 * std::tan(0.4), 0.01);
}

TEST(PointScan, WeightsAreCappedAndPositive) {
  ProjectionOptions options = plain();
  options.max_point_weight = 0.02;
  LaserScan scan = sweep(1000, 4.5);
  measure(scan, Eigen::Isometry3d::Identity());
  scan.angle_increment = 1e-9;  // every beam in one place ...
  for (const ScanPoint& point : project(scan, options).points) {
    EXPECT_GT(point.weight, 0.0);
    EXPECT_LE(point.weight, 0.02);
  }
  LaserScan sparse = sweep(20, 4.5);  // ... or metres apart
  measure(sparse, Eigen::Isometry3d::Identity());
  for (const ScanPoint& point : project(sparse, options).points) {
    EXPECT_DOUBLE_EQ(point.weight, 0.02);
  }
}

TEST(PointScan, SpacingIsHowFarTheNextBeamPasses) {
  LaserScan scan;
  scan.angle_increment = 0.1;
  scan.range_max = 10.0;
  scan.ranges = {2.0F, 4.0F, 3.0F, 20.0F, 20.0F, 1.0F};
  const PointScan projected = project(scan, plain());
  ASSERT_EQ(projected.points.size(), 4U);
  EXPECT_NEAR(projected.points[0].spacing, 2.0 * std::sin(0.1), 1e-6);
  EXPECT_NEAR(projected.points[1].spacing, 4.0 * std::sin(0.1), 1e-6)
      << "however far that one ends";
  EXPECT_NEAR(projected.points[2].spacing, 3.0 * std::sin(0.1), 1e-6) << "the nearer neighbour";
  EXPECT_NEAR(projected.points[3].spacing, std::sin(0.3), 1e-6) << "beyond beams without return";
  scan.ranges = {2.0F};
  EXPECT_NEAR(project(scan, plain()).points.at(0).spacing, 2.0, 1e-6) << "of a lone one its range";
}

TEST(PointScan, OfASurfaceWithoutNormalWhatWasHitIsKnown) {
  ScanPoint point{{2.0, 0.0}};
  point.spacing = 0.2;
  EXPECT_EQ(known_share(point), 0.25);
  point.spacing = 0.04;
  EXPECT_EQ(known_share(point), 1.0) << "denser than what a beam hits";
  point.spacing = 0.2;
  point.normal = {-1.0, 0.0};
  EXPECT_EQ(known_share(point), 1.0) << "a wall goes on";
}

TEST(PointScan, NeighboursOnAWallAreJoined) {
  const PointScan scan = scan_of_room(1000, 6.2);
  std::size_t on_one_wall = 0;
  std::size_t joined = 0;
  for (std::size_t i = 0; i + 1 < scan.points.size(); ++i) {
    const ScanPoint& a = scan.points[i];
    const ScanPoint& b = scan.points[i + 1];
    if (wall_normal(a.position) == wall_normal(b.position)) {
      ++on_one_wall;
      joined += a.joined_to_next ? 1 : 0;
    }
  }
  EXPECT_GE(joined, on_one_wall - 20) << "all but a few points next to the corners";
  EXPECT_FALSE(scan.points.back().joined_to_next);
}

TEST(PointScan, AJumpIsNoWall) {
  // A wall 2 m ahead with an opening, through which another one 3.5 m ahead is seen.
  LaserScan scan = sweep(400, 1.6);
  for (std::size_t k = 0; k < 400; ++k) {
    const double angle = angle_of(scan, k);
    const double depth = std::abs(std::tan(angle)) < 0.2 ? 3.5 : 2.0;
    scan.ranges[k] = static_cast<float>(depth / std::cos(angle));
  }
  const PointScan projected = project(scan);
  int jumps = 0;
  int joined = 0;
  for (std::size_t i = 0; i + 1 < projected.points.size(); ++i) {
    const ScanPoint& a = projected.points[i];
    if (std::abs(a.position.x() - projected.points[i + 1].position.x()) > 1.0) {
      ++jumps;
      EXPECT_FALSE(a.joined_to_next);
    } else {
      joined += a.joined_to_next ? 1 : 0;
    }
    // Both sides of a jump are flat walls; a normal across it would be a wall that is not there.
    EXPECT_TRUE(a.normal.isZero() || a.normal.x() < -0.999) << a.normal.transpose();
  }
  EXPECT_EQ(jumps, 2);
  EXPECT_GE(joined, 385);
}

TEST(PointScan, WallsAreNotJoinedBeyondTheLargestGap) {
  LaserScan scan = sweep(1000, 6.2);
  measure(scan, Eigen::Isometry3d::Identity());
  ProjectionOptions options = plain();
  options.max_wall_gap = 0.0;
  for (const ScanPoint& point : project(scan, options).points) {
    EXPECT_FALSE(point.joined_to_next);
  }
}

}  // namespace
}  // namespace matchbox_slam
