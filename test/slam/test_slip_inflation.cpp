#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "slam/slip_inflation.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kSlow = 5;  ///< key scan at the end of the first slow leg

/// Along x at 1 m/s, a key scan each 0.4 s, and 3 s for 0.4 m of it.
struct HiddenDrive {
  double slow_way = 0.4;  ///< [m]
  double slow_seconds = 3.0;
  std::size_t slow_legs = 1;  ///< of that way and time
  double speed_before = 1.0;  ///< [m/s]
  double speed_after = 1.0;
  double turn = 0.0;             ///< [rad] in each slow leg
  double direction_after = 0.0;  ///< [rad], of the way, whatever the heading
  double sigma = 0.05;           ///< [m] along the way, by scans and odometry
  Pose2 map_from_line = {};

  PlacedScans keys;
  std::vector<PoseEdge> edges;

  [[nodiscard]] std::size_t end() const { return kSlow + slow_legs - 1; }
  [[nodiscard]] double variance(std::size_t key) const { return edges[key - 1].covariance(0, 0); }

  void make() {
    Pose2 pose;
    double stamp = 10.0;
    for (std::size_t i = 0; i < end() + 3; ++i) {
      const bool is_slow = i >= kSlow && i <= end();
      const auto share = 1.0 / static_cast<double>(slow_legs);
      const double seconds = is_slow ? share * slow_seconds : 0.4;
      const double speed = is_slow     ? slow_way / slow_seconds
                           : i < kSlow ? speed_before
                                       : speed_after;
      const double direction = i > end() ? direction_after : 0.0;
      if (i > 0) {
        stamp += seconds;
        pose.x += speed * seconds * std::cos(direction);
        pose.y += speed * seconds * std::sin(direction);
        pose.theta += is_slow ? turn : 0.0;
        const Eigen::Vector3d drift = {4e-4, 4e-4, 1e-4};
        const Eigen::Vector3d seen = {sigma * sigma, 2.5e-5, 1e-6};
        const Eigen::Matrix3d covariance = (drift + seen).asDiagonal();
        edges.push_back(
            {i - 1, i, {}, covariance, EdgeKind::kMotion, LoopVerdict::kUndecided, drift});
      }
      PointScan scan;
      scan.stamp = stamp;
      keys.push_back({std::make_shared<const KeyScan>(scan), map_from_line * pose});
    }
  }

  /// Standard deviation [m] along the way that the slow legs are allowed for what may be hidden.
  [[nodiscard]] double allowed() {
    make();
    double before = 0.0;
    double after = 0.0;
    for (std::size_t key = kSlow; key <= end(); ++key) {
      before += variance(key);
    }
    inflate_for_slip(keys, end(), edges);
    for (std::size_t key = kSlow; key <= end(); ++key) {
      after += variance(key);
    }
    return std::sqrt(after - before);
  }
  [[nodiscard]] bool is_allowed_for() { return allowed() > 0.0; }
};

TEST(SlipInflation, ARobotThatDrivesOnMayNotHaveSlowedDown) {
  HiddenDrive drive;
  EXPECT_NEAR(drive.allowed(), 0.5 * (1.0 * 3.0 - 0.4), 1e-9);
  HiddenDrive other;
  other.make();
  for (std::size_t i = 0; i < drive.edges.size(); ++i) {
    Eigen::Matrix3d before = other.edges[i].covariance;
    if (i + 1 == kSlow) {
      before(0, 0) = drive.edges[i].covariance(0, 0);
    }
    EXPECT_EQ(drive.edges[i].covariance, before) << "along the way of that one alone, not " << i;
  }
}

TEST(SlipInflation, IsAsMuchHoweverManyKeyScansTellOfIt) {
  for (const std::size_t legs : {2U, 5U}) {
    HiddenDrive drive;
    drive.slow_legs = legs;
    EXPECT_NEAR(drive.allowed(), 1.3, 1e-9) << legs;
    EXPECT_NEAR(drive.variance(kSlow), drive.variance(kSlow + 1), 1e-9);
  }
}

TEST(SlipInflation, NothingIsDoneBeforeTheStretchHasEnded) {
  HiddenDrive drive;
  drive.slow_legs = 3;
  drive.make();
  const double before = drive.variance(kSlow);
  for (const std::size_t key : {kSlow, kSlow + 1, kSlow + 3}) {
    inflate_for_slip(drive.keys, key, drive.edges);
    EXPECT_EQ(drive.variance(kSlow), before) << key;
    EXPECT_EQ(drive.variance(kSlow + 1), before) << key;
  }
  inflate_for_slip(drive.keys, kSlow + 2, drive.edges);
  EXPECT_GT(drive.variance(kSlow), before);
}

TEST(SlipInflation, IsAlongTheWayInWhicheverFrame) {
  HiddenDrive drive;
  drive.map_from_line = {31.0, -7.0, 2.1};
  EXPECT_NEAR(drive.allowed(), 1.3, 1e-9);
  EXPECT_NEAR(drive.edges[kSlow - 1].covariance(1, 1), 4e-4 + 2.5e-5, 1e-12);
}

TEST(SlipInflation, WhatIsCertainlySlowerIsSo) {
  HiddenDrive drive;
  drive.slow_seconds = 2.0;
  drive.slow_way = 1.19;
  EXPECT_TRUE(drive.is_allowed_for());
  drive = {};
  drive.slow_seconds = 2.0;
  drive.slow_way = 1.21;
  EXPECT_FALSE(drive.is_allowed_for()) << "six tenths of its speed";
  drive = {};
  drive.slow_seconds = 5.9;
  EXPECT_TRUE(drive.is_allowed_for());
  drive = {};
  drive.slow_seconds = 6.1;
  EXPECT_FALSE(drive.is_allowed_for()) << "it stood";
  drive = {};
  drive.slow_seconds = 0.4;
  drive.slow_way = 0.11;
  EXPECT_FALSE(drive.is_allowed_for()) << "0.29 m";
  drive = {};
  drive.slow_seconds = 0.4;
  drive.slow_way = 0.09;
  EXPECT_TRUE(drive.is_allowed_for());
}

TEST(SlipInflation, ARobotThatHardlyDrivesHidesNothing) {
  for (const double speed : {0.19, 0.21}) {
    HiddenDrive drive;
    drive.speed_before = drive.speed_after = speed;
    drive.slow_way = 0.05;
    EXPECT_EQ(drive.is_allowed_for(), speed > 0.2);
  }
}

TEST(SlipInflation, ARobotThatSpeedsUpOrSlowsDownHidesNoMoreThanItsSlowerSpeed) {
  HiddenDrive drive;
  drive.speed_after = 0.7;
  EXPECT_NEAR(drive.allowed(), 0.5 * (0.7 * 3.0 - 0.4), 1e-9);
  drive = {};
  drive.speed_before = 0.7;
  EXPECT_NEAR(drive.allowed(), 0.5 * (0.7 * 3.0 - 0.4), 1e-9);
  drive = {};
  drive.speed_before = 0.5;
  EXPECT_FALSE(drive.is_allowed_for()) << "it was slow before";
}

TEST(SlipInflation, ARobotThatTurnsSlowsDownForIt) {
  HiddenDrive drive;
  drive.turn = 0.31;
  EXPECT_FALSE(drive.is_allowed_for());
  drive = {};
  drive.turn = -0.29;
  EXPECT_TRUE(drive.is_allowed_for());
  drive = {};
  drive.direction_after = 3.0;
  EXPECT_FALSE(drive.is_allowed_for()) << "it goes back";
}

TEST(SlipInflation, WhereScansTellHowFarNothingIsHidden) {
  HiddenDrive drive;
  drive.sigma = 0.019;
  EXPECT_FALSE(drive.is_allowed_for());
  drive = {};
  drive.sigma = 0.021;
  EXPECT_TRUE(drive.is_allowed_for());
}

TEST(SlipInflation, WithoutLegsBeforeAndAfterNothingIsKnown) {
  HiddenDrive drive;
  drive.make();
  const double before = drive.variance(kSlow);
  const PlacedScans newest(drive.keys.begin(), drive.keys.begin() + kSlow + 1);
  inflate_for_slip(newest, kSlow, drive.edges);
  EXPECT_EQ(drive.variance(kSlow), before);
  const PlacedScans since(drive.keys.begin() + kSlow - 1, drive.keys.end());
  std::vector<PoseEdge> edges(drive.edges.begin(), drive.edges.begin() + 2);
  inflate_for_slip(since, 1, edges);
  EXPECT_EQ(edges.front().covariance(0, 0), before);
}

/// Those that came later than they were seen, and of another laser, which are as old.
TEST(SlipInflation, KeyScansThatAreNotInOrderTellOfNoSpeed) {
  HiddenDrive drive;
  drive.make();
  const auto is_allowed_for = [&](const PlacedScans& keys) {
    std::vector<PoseEdge> edges = drive.edges;
    inflate_for_slip(keys, kSlow, edges);
    return edges[kSlow - 1].covariance(0, 0) > drive.variance(kSlow);
  };
  EXPECT_TRUE(is_allowed_for(drive.keys));
  PlacedScans later = drive.keys;
  std::swap(later[kSlow - 2].scan, later[kSlow - 1].scan);
  EXPECT_FALSE(is_allowed_for(later));
  PlacedScans as_old = drive.keys;
  as_old[kSlow + 1].scan = as_old[kSlow].scan;
  EXPECT_FALSE(is_allowed_for(as_old));
}

TEST(SlipInflation, ALoopIsNoMotion) {
  HiddenDrive drive;
  drive.make();
  PoseEdge loop = drive.edges[kSlow - 1];
  loop.kind = EdgeKind::kLoop;
  drive.edges.push_back(loop);
  inflate_for_slip(drive.keys, kSlow, drive.edges);
  EXPECT_EQ(drive.edges.back().covariance, loop.covariance);
  EXPECT_GT(drive.variance(kSlow), 1.0);
}

}  // namespace
}  // namespace matchbox_slam
