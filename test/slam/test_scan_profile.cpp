#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "matchbox_slam/geometry/angles.hpp"
#include "slam/scan_profile.hpp"

namespace matchbox_slam {
namespace {

/// What is seen from a place in a room of 8 m by 6 m, whose middle is the origin.
PointScan look(const Pose2& room_from_base, int beams = 360) {
  PointScan scan;
  for (int i = 0; i < beams; ++i) {
    const double angle = -kPi + 2.0 * kPi * (i + 0.5) / beams;
    const double heading = room_from_base.theta + angle;
    const Eigen::Vector2d ray(std::cos(heading), std::sin(heading));
    const Eigen::Vector2d from = room_from_base.translation();
    const double to_x = ((ray.x() > 0.0 ? 4.0 : -4.0) - from.x()) / ray.x();
    const double to_y = ((ray.y() > 0.0 ? 3.0 : -3.0) - from.y()) / ray.y();
    ScanPoint point;
    point.position = std::min(to_x, to_y) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    point.weight = 0.05;
    scan.points.push_back(point);
  }
  return scan;
}

TEST(ScanProfile, HasTheNearestOfEachDirection) {
  PointScan scan;
  for (const double x : {3.0, 2.0, 5.0}) {
    ScanPoint point;
    point.position = {x, 0.01};
    scan.points.push_back(point);
  }
  const ScanProfile profile = profile_of(scan);
  constexpr std::size_t kAhead = std::tuple_size_v<ScanProfile> / 2;
  EXPECT_NEAR(profile[kAhead], 2.0F, 1e-3F);
  for (std::size_t i = 0; i < profile.size(); ++i) {
    EXPECT_EQ(profile[i] > 0.0F, i == kAhead) << i;
  }
}

TEST(ScanProfile, ChangesInNothingWhereTheMotionExplainsIt) {
  const Pose2 before{0.5, -0.3, 0.4};
  for (const Pose2& moved : {Pose2{}, Pose2{0.2, 0.0, 0.0}, Pose2{0.0, 0.0, 0.5}}) {
    const double changed =
        changed_share(profile_of(look(before * moved)), profile_of(look(before)), moved);
    EXPECT_LE(changed, 0.06) << moved.x << " " << moved.theta;
  }
}

TEST(ScanProfile, ChangesWhereTheRobotIsMovedUnawares) {
  const ScanProfile before = profile_of(look({0.0, 0.0, 0.0}));
  EXPECT_GT(changed_share(profile_of(look({2.0, 0.0, 0.0})), before, {}), 0.4);
  EXPECT_GT(changed_share(profile_of(look({0.0, 0.0, 0.25 * kPi})), before, {}), 0.3);
}

TEST(ScanProfile, ChangesInNothingWithoutAScanBefore) {
  const ScanProfile profile = profile_of(look({}));
  EXPECT_EQ(changed_share(profile, {}, {}), 0.0);
  EXPECT_EQ(changed_share(profile_of({}), profile, {}), 0.0);
}

}  // namespace
}  // namespace matchbox_slam
