#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "simulation/laser.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

/// A wall across the x axis, 4 m ahead of the origin, and nothing else.
World one_wall() { return {{{{4.0, -100.0}, {4.0, 100.0}}}, {}}; }

PoseAtTime at_rest(const Pose2& pose) {
  return [pose](double /*time*/) { return pose; };
}

LaserOptions centred_laser() {
  LaserOptions options;
  options.mount_x = 0.0;
  options.range_noise = 0.0;
  options.dropout = 0.0;
  return options;
}

double angle_of(const LaserScan& scan, std::size_t beam) {
  return scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
}

TEST(Laser, TheDefaultsAreTheStataLaser) {
  const LaserScan scan = ideal_scan(one_wall(), {}, {}, 12.5);
  EXPECT_EQ(scan.stamp, 12.5);
  EXPECT_EQ(scan.ranges.size(), 1040U);
  EXPECT_NEAR(scan.angle_min, degrees_to_radians(-130.0), 1e-12);
  EXPECT_NEAR(scan.angle_increment, degrees_to_radians(0.25), 1e-12);
  EXPECT_EQ(scan.time_increment, 0.0);
  EXPECT_EQ(scan.range_max, 30.0);
  // Beam 520 looks straight ahead, from 0.275 m ahead of the base.
  EXPECT_NEAR(scan.ranges[520], 4.0 - 0.275, 1e-6);
}

TEST(Laser, RangesAreThoseOfGeometry) {
  const Pose2 world_from_base{1.0, 2.0, 0.3};
  const LaserScan scan = ideal_scan(one_wall(), centred_laser(), world_from_base);
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const double direction = world_from_base.theta + angle_of(scan, k);
    const double range = std::cos(direction) > 0.0 ? 3.0 / std::cos(direction) : 1e9;
    if (range < 30.0) {
      EXPECT_NEAR(scan.ranges[k], range, 1e-5 * range);
    } else {
      EXPECT_EQ(scan.ranges[k], std::numeric_limits<float>::infinity());
    }
  }
}

TEST(Laser, TruthTellsSegmentNormalAndIncidence) {
  const World world = one_wall();
  const auto truth = trace_beams(world, centred_laser(), at_rest({0.0, 0.0, 0.0}), 0.0);
  ASSERT_EQ(truth.size(), 1040U);
  for (const std::size_t k : {400U, 520U, 600U}) {
    const double angle = degrees_to_radians(-130.0 + 0.25 * static_cast<double>(k));
    EXPECT_EQ(truth[k].segment, 0U);
    EXPECT_EQ(truth[k].normal, Eigen::Vector2d(-1.0, 0.0));
    EXPECT_NEAR(truth[k].cos_incidence, std::cos(angle), 1e-12);
    EXPECT_NEAR(truth[k].range, 4.0 / std::cos(angle), 1e-12);
  }
  EXPECT_FALSE(truth[0].segment);
  EXPECT_EQ(truth[0].range, std::numeric_limits<double>::infinity());
}

TEST(Laser, MountIsAppliedInFull) {
  const World world = make_rooms_world(2);
  const Eigen::Vector2d start = world.route().waypoints.front();
  const Pose2 world_from_base{start.x(), start.y(), 0.4};
  LaserOptions mounted = centred_laser();
  mounted.mount_x = 0.2;
  mounted.mount_y = -0.1;
  mounted.mount_yaw = 0.7;
  const LaserScan scan = ideal_scan(world, mounted, world_from_base);
  const LaserScan expected =
      ideal_scan(world, centred_laser(), world_from_base * Pose2{0.2, -0.1, 0.7});
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    ASSERT_NEAR(scan.ranges[k], expected.ranges[k], 1e-5) << k;
  }
}

TEST(Laser, UpsideDownItMeasuresTheMirrorImage) {
  const World world = make_rooms_world(2);
  const Eigen::Vector2d start = world.route().waypoints.front();
  const Pose2 world_from_base{start.x(), start.y(), 0.4};
  LaserOptions clockwise = centred_laser();
  clockwise.clockwise = true;
  LaserOptions inverted = centred_laser();
  inverted.mount_roll = kPi;
  // Upside down, beam k at angle a looks where angle -a looks on an upright laser: from left to
  // right, as an upright laser that sweeps clockwise does.
  const LaserScan expected = ideal_scan(world, clockwise, world_from_base);
  const LaserScan scan = ideal_scan(world, inverted, world_from_base);
  EXPECT_LT(expected.angle_increment, 0.0);
  EXPECT_GT(scan.angle_increment, 0.0);
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    ASSERT_NEAR(scan.ranges[k], expected.ranges[k], 1e-5) << k;
  }
}

TEST(Laser, TiltedItSeesUprightWallsFartherAway) {
  LaserOptions tilted = centred_laser();
  tilted.mount_pitch = 0.3;
  EXPECT_NEAR(ideal_scan(one_wall(), tilted, {}).ranges[520], 4.0 / std::cos(0.3), 1e-5);
}

TEST(Laser, LookingDownItSeesTheFloorAndTables) {
  const auto table = [] {
    WallSegment line{{2.0, -50.0}, {2.0, 50.0}};
    line.is_table = true;
    return line;
  }();
  const World world({{{4.0, -50.0}, {4.0, 50.0}}, table}, {});
  LaserOptions laser = centred_laser();
  laser.mount_z = 0.35 - kBaseHeight;
  laser.table_height = 0.2;
  EXPECT_NEAR(ideal_scan(world, laser, {}).ranges[520], 4.0, 1e-5) << "over the table";
  laser.mount_pitch = 0.1;
  EXPECT_NEAR(ideal_scan(world, laser, {}).ranges[520], 2.0 / std::cos(0.1), 1e-5);
  laser.mount_pitch = 0.06;  // it is 0.23 m above the floor at the table, and 0.11 m at the wall
  EXPECT_NEAR(ideal_scan(world, laser, {}).ranges[520], 4.0 / std::cos(0.06), 1e-5);
  laser.mount_pitch = 0.25;
  EXPECT_NEAR(ideal_scan(world, laser, {}).ranges[520], 2.0 / std::cos(0.25), 1e-5) << "no floor";
  laser.floor = true;
  const auto truth = trace_beams(world, laser, at_rest({}), 0.0);
  EXPECT_NEAR(truth[520].range, 0.35 / std::sin(0.25), 1e-9);
  EXPECT_FALSE(truth[520].segment);
  laser.mount_pitch = -0.25;
  EXPECT_NEAR(ideal_scan(world, laser, {}).ranges[520], 4.0 / std::cos(0.25), 1e-5);
}

TEST(Laser, RocksAndNodsByUpToWhatIsAskedFor) {
  LaserOptions laser = centred_laser();
  laser.rock = 0.1;
  laser.nod = 0.3;
  double most_pitch = 0.0;
  double most_roll = 0.0;
  double most_nod = 0.0;
  for (double time = 0.0; time < 20.0; time += 0.01) {
    const Eigen::Matrix3d rocked = laser.rocked(time).linear();
    most_pitch = std::max(most_pitch, std::abs(std::asin(rocked(2, 0))));
    most_roll = std::max(most_roll, std::abs(std::atan2(rocked(2, 1), rocked(2, 2))));
    most_nod = std::max(most_nod, std::abs(std::asin(laser.nodded(time).linear()(2, 0))));
  }
  EXPECT_NEAR(most_pitch, 0.1, 1e-3);
  EXPECT_NEAR(most_roll, 0.1, 1e-3);
  EXPECT_NEAR(most_nod, 0.3, 1e-3);
  const double stamp = 1000.7;
  LaserOptions mounted = centred_laser();
  mounted.mount_pitch = std::asin(-laser.nodded(stamp).linear()(2, 0));
  laser.rock = 0.0;
  EXPECT_NEAR(ideal_scan(one_wall(), laser, {}, stamp).ranges[520],
              ideal_scan(one_wall(), mounted, {}, stamp).ranges[520], 1e-5);
}

TEST(Laser, ReadsWhatRep117Asks) {
  LaserOptions options = centred_laser();
  options.range_min = 4.1;
  options.range_max = 5.0;
  LaserScan scan = ideal_scan(one_wall(), options, {});
  EXPECT_EQ(scan.ranges[520], -std::numeric_limits<float>::infinity());
  EXPECT_EQ(scan.ranges[0], std::numeric_limits<float>::infinity());
  options.no_return = "over_range";
  scan = ideal_scan(one_wall(), options, {});
  EXPECT_EQ(scan.ranges[0], 6.0F);
  options.dropout = 1.0;
  scan = simulate_scan(one_wall(), options, at_rest({}), 0.0, 1).scan;
  EXPECT_TRUE(std::isnan(scan.ranges[520]));
}

TEST(Laser, ReadsZeroOrNanForAllThatTellsNothing) {
  LaserOptions options = centred_laser();
  options.range_min = 4.1;
  options.range_max = 5.0;
  options.no_return = "zero";
  LaserScan scan = ideal_scan(one_wall(), options, {});
  EXPECT_EQ(scan.ranges[520], 0.0F) << "too near";
  EXPECT_EQ(scan.ranges[0], 0.0F) << "nothing met";
  options.no_return = "nan";
  scan = ideal_scan(one_wall(), options, {});
  EXPECT_TRUE(std::isnan(scan.ranges[520]));
  EXPECT_TRUE(std::isnan(scan.ranges[0]));
  options.no_return = "zero";
  options.dropout = 1.0;
  scan = simulate_scan(one_wall(), options, at_rest({}), 0.0, 1).scan;
  EXPECT_EQ(scan.ranges, std::vector<float>(scan.ranges.size(), 0.0F));
}

TEST(Laser, WhatPassesARailingIsDrawnAnewForEachScanByTheWorldsSeed) {
  WallSurface railing;
  railing.passing = 0.5;
  const auto world = [&](std::uint64_t seed) {
    return World({{{4.0, -100.0}, {4.0, 100.0}, false, railing}}, {}, {}, seed);
  };
  const auto ranges = [&](std::uint64_t seed, double stamp) {
    return ideal_scan(world(seed), centred_laser(), {}, stamp).ranges;
  };
  const auto returned = [](const std::vector<float>& all) {
    return std::count_if(all.begin(), all.end(), [](float range) { return std::isfinite(range); });
  };
  const auto met = returned(ideal_scan(one_wall(), centred_laser(), {}).ranges);
  EXPECT_NEAR(static_cast<double>(returned(ranges(1, 100.0))) / static_cast<double>(met), 0.5, 0.1);
  EXPECT_EQ(ranges(1, 100.0), ranges(1, 100.0));
  EXPECT_EQ(ranges(1, 100.0), ranges(1, 100.00001)) << "but for rounding";
  EXPECT_NE(ranges(1, 100.0), ranges(1, 100.05));
  EXPECT_NE(ranges(1, 100.0), ranges(2, 100.0));
}

TEST(Laser, NoiseHasTheDeviationAskedFor) {
  LaserOptions options = centred_laser();
  options.range_noise = 0.02;
  options.dropout = 0.05;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  double count = 0.0;
  double lost = 0.0;
  double beams = 0.0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const SimulatedScan scan = simulate_scan(one_wall(), options, at_rest({}), 0.0, seed);
    for (std::size_t k = 0; k < scan.truth.size(); ++k) {
      const auto range = static_cast<double>(scan.scan.ranges[k]);
      lost += std::isnan(range) ? 1.0 : 0.0;
      beams += 1.0;
      if (scan.truth[k].range < 20.0 && !std::isnan(range)) {
        const double error = range - scan.truth[k].range;
        sum += error;
        sum_of_squares += error * error;
        count += 1.0;
      }
    }
  }
  ASSERT_GT(count, 100000.0 * 0.6);
  EXPECT_NEAR(sum / count, 0.0, 4.0 * 0.02 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(sum_of_squares / count), 0.02, 4.0 * 0.02 / std::sqrt(2.0 * count));
  EXPECT_NEAR(lost / beams, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / beams));
}

TEST(Laser, OutliersLieAnywhereBeforeTheWallAndLeaveTheOthersAlone) {
  LaserOptions options = centred_laser();
  options.range_noise = 0.01;
  const LaserScan without = simulate_scan(one_wall(), options, at_rest({}), 0.0, 1).scan;
  options.outliers = 0.3;
  const SimulatedScan with = simulate_scan(one_wall(), options, at_rest({}), 0.0, 1);
  int outliers = 0;
  int in_the_first_half = 0;
  for (std::size_t k = 0; k < with.scan.ranges.size(); ++k) {
    const float range = with.scan.ranges[k];
    if (range == without.ranges[k]) {
      continue;
    }
    const double wall = std::min(with.truth[k].range, options.range_max);
    ++outliers;
    EXPECT_LT(range, wall + 0.05) << k;
    in_the_first_half += range < 0.5 * wall ? 1 : 0;
  }
  EXPECT_NEAR(outliers, 0.3 * 1040.0, 50.0);
  EXPECT_NEAR(in_the_first_half, 0.5 * outliers, 30.0);
}

TEST(Laser, TheSeedSaysEverything) {
  const LaserOptions options;
  const LaserScan scan =
      simulate_scan(one_wall(), without_noise(options), at_rest({}), 0.0, 5).scan;
  EXPECT_EQ(scan.ranges, ideal_scan(one_wall(), options, {}).ranges);
  LaserOptions noisy = options;
  noisy.dropout = 0.0;
  const auto first = simulate_scan(one_wall(), noisy, at_rest({}), 0.0, 5).scan.ranges;
  EXPECT_EQ(first, simulate_scan(one_wall(), noisy, at_rest({}), 0.0, 5).scan.ranges);
  EXPECT_NE(first, simulate_scan(one_wall(), noisy, at_rest({}), 0.0, 6).scan.ranges);
}

TEST(Laser, ASweptScanMeasuresEachBeamFromWhereTheRobotIsThen) {
  const World world = make_loop_world(4);
  const Eigen::Vector2d start = world.route().waypoints.front();
  const PoseAtTime world_from_base = [&](double time) {
    return Pose2{start.x() + 0.9 * time, start.y(), 0.2 + 1.5 * time};
  };
  LaserOptions options = without_noise(LaserOptions{});
  options.time_increment = 4e-5;
  constexpr double kStamp = 0.25;
  const LaserScan scan = simulate_scan(world, options, world_from_base, kStamp, 1).scan;
  EXPECT_EQ(scan.time_increment, 4e-5);
  LaserOptions instantaneous = options;
  instantaneous.time_increment = 0.0;
  double largest_skew = 0.0;
  const LaserScan unswept = ideal_scan(world, instantaneous, world_from_base(kStamp));
  for (std::size_t k = 0; k < scan.ranges.size(); k += 7) {
    const Pose2 pose = world_from_base(kStamp + static_cast<double>(k) * options.time_increment);
    ASSERT_EQ(scan.ranges[k], ideal_scan(world, instantaneous, pose).ranges[k]) << k;
    largest_skew =
        std::max(largest_skew, static_cast<double>(std::abs(scan.ranges[k] - unswept.ranges[k])));
  }
  EXPECT_GT(largest_skew, 0.05);
}

TEST(Laser, RefusesOptionsThatDoNotFitTogether) {
  LaserOptions options;
  options.time_increment = 1e-3;
  EXPECT_THROW((void)ideal_scan(one_wall(), options, {}), ConfigurationError);
  options = {};
  options.range_min = 40.0;
  EXPECT_THROW((void)ideal_scan(one_wall(), options, {}), ConfigurationError);
  options = {};
  options.parts = 7;
  EXPECT_THROW((void)ideal_scan(one_wall(), options, {}), ConfigurationError);
}

}  // namespace
}  // namespace matchbox_slam
