#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/lasers/secondary_lasers.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

const Eigen::Vector3d kAtRest = Eigen::Vector3d::Zero();

Eigen::Isometry3d mounted_at(const Pose2& base_from_laser, double height = 0.3) {
  return Eigen::Translation3d(base_from_laser.x, base_from_laser.y, height) *
         Eigen::AngleAxisd(base_from_laser.theta, Eigen::Vector3d::UnitZ());
}

ScanInput scan_of(int laser, double stamp, const Pose2& base_from_laser = {}) {
  ScanInput input;
  input.scan.stamp = stamp;
  input.laser = laser;
  input.base_from_laser = mounted_at(base_from_laser);
  return input;
}

void expect_near(const Pose2& pose, const Pose2& expected, double tolerance = 1e-9) {
  EXPECT_LT(difference(pose, expected).cwiseAbs().maxCoeff(), tolerance)
      << pose.x << " " << pose.y << " " << pose.theta;
}

/// Samples that say so of the mount, at rest and moving: it is sure.
ExtrinsicCalibration sure_mount(const Pose2& off) {
  std::vector<ExtrinsicSample> samples;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d velocity(0.1 * (i % 5), 0.0, 0.2 * (i % 3 - 1));
    samples.push_back({{off.x, off.y, off.theta}, covariance_of(1e-3, 1e-3), velocity});
  }
  return ExtrinsicCalibration(std::move(samples));
}

/// Laser 1 is used; tf has it off by so much.
SecondaryLasers with_used_laser(const Pose2& off, const Pose2& newest_from_tried = {}) {
  SecondaryLaser one;
  one.mount = sure_mount(off);
  one.is_used = true;
  one.newest_from_tried = newest_from_tried;
  return {{{1, one}}, {}};
}

// --- who leads ---

TEST(SecondaryLasers, TheFirstLeadsAsLongAsItIsHeard) {
  SecondaryLasers lasers;
  double newest = 10.0;
  for (int i = 0; i < 50; ++i) {
    newest = 10.0 + 0.4 * i;
    EXPECT_TRUE(lasers.select_primary(scan_of(0, newest), newest - 0.4));
    for (int between = 1; between < 8; ++between) {
      EXPECT_FALSE(lasers.select_primary(scan_of(1, newest + 0.05 * between), newest));
    }
  }
  EXPECT_EQ(lasers.primary().laser, 0);
}

/// For more than five scans and half a second.
TEST(SecondaryLasers, AnotherLeadsWhileThePrimaryOneIsSilent) {
  const auto primary_at = [](double interval) {
    SecondaryLasers lasers;
    int i = 1;
    while (i < 100 && !lasers.select_primary(scan_of(1, 10.0 + interval * i), 10.0)) {
      ++i;
    }
    return i;
  };
  EXPECT_EQ(primary_at(1.0), 6) << "six scans";
  EXPECT_EQ(primary_at(0.0625), 9) << "more than half a second";
}

TEST(SecondaryLasers, SilenceIsCountedAnewWithEachScanOfThePrimaryOne) {
  SecondaryLasers lasers;
  for (int i = 1; i <= 5; ++i) {
    EXPECT_FALSE(lasers.select_primary(scan_of(1, 10.0 + i), 10.0));
  }
  EXPECT_TRUE(lasers.select_primary(scan_of(0, 16.0), 10.0));
  for (int i = 1; i <= 5; ++i) {
    EXPECT_FALSE(lasers.select_primary(scan_of(1, 16.0 + i), 16.0));
  }
  EXPECT_TRUE(lasers.select_primary(scan_of(1, 22.0), 16.0));
  EXPECT_TRUE(lasers.select_primary(scan_of(1, 22.1), 22.0));
  EXPECT_TRUE(lasers.select_primary(scan_of(0, 22.2), 22.1)) << "the first leads at once again";
  EXPECT_FALSE(lasers.select_primary(scan_of(1, 22.3), 22.2));
}

TEST(SecondaryLasers, BeforeAnyScanSilenceBeginsWithTheFirstOfAnother) {
  SecondaryLasers lasers;
  int i = 0;
  while (i < 100 && !lasers.select_primary(scan_of(1, 10.0 + 0.0625 * i), std::nullopt)) {
    ++i;
  }
  EXPECT_EQ(i, 9);  // more than half a second after the first
}

/// Which else would be taken into account twice.
TEST(SecondaryLasers, WhatWaitedOfTheOneThatLeadsNowIsDropped) {
  SecondaryLasers lasers = with_used_laser({});
  for (int i = 1; i <= 5; ++i) {
    ASSERT_FALSE(lasers.select_primary(scan_of(1, 10.0 + 0.125 * i), 10.0));
    lasers.wait(scan_of(1, 10.0 + 0.125 * i), kAtRest, {}, {}, {});
  }
  ASSERT_TRUE(lasers.all().at(1).waiting);
  ASSERT_TRUE(lasers.select_primary(scan_of(1, 10.75), 10.0));
  EXPECT_FALSE(lasers.all().at(1).waiting);
}

TEST(SecondaryLasers, KeepWhereTfHasThem) {
  SecondaryLasers lasers;
  const Pose2 base_from_laser{-0.4, 0.1, 3.0};
  (void)lasers.select_primary(scan_of(2, 10.0, base_from_laser), 10.0);
  (void)lasers.select_primary(scan_of(0, 10.1, {0.3, 0.0, 0.0}), 10.0);
  ASSERT_EQ(lasers.all().size(), 1U) << "of the secondary ones";
  expect_near(lasers.all().at(2).base_from_laser, base_from_laser);
}

// --- where they are ---

TEST(SecondaryLasers, TfIsPutRightOnceTheMountIsSure) {
  const ScanInput input = scan_of(1, 10.0, {-0.4, 0.1, 3.0});
  const Pose2 off{0.03, -0.02, 0.04};
  EXPECT_EQ(SecondaryLasers().base_from_laser(input, kAtRest).matrix(),
            input.base_from_laser.matrix());
  SecondaryLaser unused;
  unused.mount = sure_mount(off);
  EXPECT_EQ(SecondaryLasers({{1, unused}}, {}).base_from_laser(input, kAtRest).matrix(),
            input.base_from_laser.matrix());

  const Eigen::Isometry3d corrected = with_used_laser(off).base_from_laser(input, kAtRest);
  const Pose2 expected = off * Pose2{-0.4, 0.1, 3.0};
  // The estimate's prior draws it to zero, by little.
  EXPECT_NEAR(corrected.translation().x(), expected.x, 2e-4);
  EXPECT_NEAR(corrected.translation().y(), expected.y, 2e-4);
  EXPECT_EQ(corrected.translation().z(), 0.3);
  EXPECT_NEAR(std::atan2(corrected.linear()(1, 0), corrected.linear()(0, 0)), expected.theta, 2e-4);
}

// --- scans that wait ---

TEST(SecondaryLasers, OnlyScansOfThoseThatAreUsedWait) {
  SecondaryLasers lasers({{1, {}}}, {});
  lasers.wait(scan_of(1, 10.0), kAtRest, {}, {}, {});
  EXPECT_TRUE(lasers.take_waiting(10.1, {}).empty());
}

TEST(SecondaryLasers, WhatWaitedLiesInTheBaseOfTheScanThatTakesIt) {
  SecondaryLasers lasers = with_used_laser({});
  const Pose2 newest_from_there{0.2, 0.1, 0.3};
  const Pose2 newest_from_base{0.5, -0.1, -0.4};
  const Pose2 motion{0.01, 0.0, 0.002};
  lasers.wait(scan_of(1, 10.1), kAtRest, {9.0, 9.0, 9.0}, {}, {});
  lasers.wait(scan_of(1, 10.2), kAtRest, newest_from_there, motion, {});
  const std::map<int, SecondaryScan> taken = lasers.take_waiting(10.4, newest_from_base);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken.at(1).measured.scan.stamp, 10.2) << "the newest";
  EXPECT_EQ(taken.at(1).measured.motion, motion);
  expect_near(newest_from_base * taken.at(1).there_from_base, newest_from_there);
  EXPECT_TRUE(lasers.take_waiting(10.5, newest_from_base).empty()) << "once";
}

TEST(SecondaryLasers, WhatWaitedTooLongIsNotTaken) {
  SecondaryLasers lasers = with_used_laser({});
  lasers.wait(scan_of(1, 10.0), kAtRest, {}, {}, {});
  EXPECT_EQ(lasers.take_waiting(10.5, {}).size(), 1U);
  lasers.wait(scan_of(1, 10.0), kAtRest, {}, {}, {});
  EXPECT_TRUE(lasers.take_waiting(10.5625, {}).empty());
  EXPECT_TRUE(lasers.take_waiting(10.25, {}).empty()) << "nor by a later one";
}

// --- samples ---

TEST(SecondaryLasers, ASampleIsDueAfterSomeMotionAndLaterOnceUsed) {
  SecondaryLaser tried;
  tried.newest_from_tried = Pose2{1.0, 2.0, 0.5};
  const auto is_due = [&](const Pose2& moved) {
    return SecondaryLasers({{1, tried}}, {}).is_sample_due(1, *tried.newest_from_tried * moved);
  };
  for (const double part : {1.0, 5.0}) {
    tried.is_used = part > 1.0;
    EXPECT_FALSE(is_due({part * 0.07, part * 0.07, part * 0.049}));
    EXPECT_TRUE(is_due({part * 0.08, part * -0.08, 0.0}));
    EXPECT_TRUE(is_due({0.0, 0.0, part * -0.051}));
  }
  tried.newest_from_tried.reset();
  EXPECT_TRUE(SecondaryLasers({{1, tried}}, {}).is_sample_due(1, {})) << "the first";
}

/// However the primary laser's scans cut the way up.
TEST(SecondaryLasers, TheWaySinceASampleAddsUpFromScanToScan) {
  SecondaryLasers lasers = with_used_laser({}, {});
  const Pose2 step{0.06, 0.0, 0.01};
  for (int i = 1; i <= 8; ++i) {  // 0.48 m, 0.08 rad
    lasers.move_on(step);
  }
  EXPECT_FALSE(lasers.is_sample_due(1, {}));
  EXPECT_TRUE(lasers.is_sample_due(1, {0.06, 0.0, 0.0}));
  Pose2 way;
  for (int i = 1; i <= 8; ++i) {
    way = way * step;
  }
  expect_near(*lasers.all().at(1).newest_from_tried, way.inverse());
}

/// A drive through rooms with a second laser that looks back; tf has it elsewhere.
class SampledDrive {
 public:
  /// @param laser  what is known of the second one.
  explicit SampledDrive(const Pose2& off, const Pose2& map_from_world = {},
                        const SecondaryLaser& laser = {})
      : map_from_world_(map_from_world), lasers_({{1, laser}}, {}) {
    behind_.beams = 180;
    behind_.mount_x = -0.2;
    behind_.mount_yaw = kPi;
    ahead_.beams = 180;
    by_tf_ = mounted_at(off, 0.0).inverse() * behind_.base_from_laser();
  }

  /// Both lasers see what there is each 0.3 s.
  void drive_on(int scans) {
    for (int i = 0; i < scans; ++i) {
      world_from_base_ = motion_.pose(time_ += 0.3);
      keys_.add(
          MeasuredScan{
              ideal_scan(world_, ahead_, world_from_base_), ahead_.base_from_laser(), {}, {}},
          0, map_from_world_ * world_from_base_);
      sample();
    }
  }

  /// A sample of what the second laser sees where the base is.
  /// @param off  [m] by which it is taken to be elsewhere.
  void sample(double off = 0.0) {
    const Pose2 map_from_base = map_from_world_ * world_from_base_ * Pose2{off, 0.0, 0.0};
    lasers_.sample(1, project_scan(ideal_scan(world_, behind_, world_from_base_), by_tf_, {}, {}),
                   map_from_base, {}, kAtRest, keys_.all(), {}, {});
  }
  void set_beams(int beams) { behind_.beams = beams; }

  [[nodiscard]] const SecondaryLaser& laser() const { return lasers_.all().at(1); }
  [[nodiscard]] std::size_t samples() const { return laser().mount.samples().size(); }

 private:
  Pose2 map_from_world_;
  World world_ = make_rooms_world(3);
  RobotMotion motion_ = drive(world_.route(), {});
  LaserOptions ahead_;
  LaserOptions behind_;
  Eigen::Isometry3d by_tf_;
  double time_ = 4.0;
  Pose2 world_from_base_;
  KeyScans keys_;
  SecondaryLasers lasers_;
};

TEST(SecondaryLasers, LearnWhereTheyAreFromHowTheyFitWhatThePrimaryOneSaw) {
  for (const Pose2& off : {Pose2{}, Pose2{0.05, -0.04, 0.03}, Pose2{-0.03, 0.06, -0.02}}) {
    SampledDrive driven(off);
    driven.drive_on(60);
    EXPECT_TRUE(driven.laser().is_used);
    expect_near(driven.laser().mount.correction(kAtRest), off, 0.003);
  }
}

TEST(SecondaryLasers, WhatTheyLearnDoesNotDependOnTheMapsFrame) {
  const Pose2 off{0.05, -0.04, 0.03};
  SampledDrive here(off);
  SampledDrive driven(off, {-44.0, 17.0, 1.1});
  here.drive_on(60);
  driven.drive_on(60);
  EXPECT_TRUE(driven.laser().is_used);
  expect_near(driven.laser().mount.correction(kAtRest), off, 0.003);
  const Eigen::Matrix3d expected = here.laser().mount.samples().front().covariance;
  const Eigen::Matrix3d covariance = driven.laser().mount.samples().front().covariance;
  EXPECT_LT((covariance - expected).norm(), 0.1 * expected.norm());
}

TEST(SecondaryLasers, WhatLiesNowhereNearThePrimaryOnesScansTeachesNothing) {
  SampledDrive driven({});
  driven.drive_on(20);
  const std::size_t before = driven.samples();
  driven.sample();
  EXPECT_EQ(driven.samples(), before + 1);
  driven.sample(300.0);
  EXPECT_EQ(driven.samples(), before + 1);
  EXPECT_EQ(driven.laser().newest_from_tried, Pose2{}) << "though it was tried";
}

/// Of those that lie where something was seen, which are two thirds here.
TEST(SecondaryLasers, OfLessThanThirtyPointsNothingIsLearnt) {
  SampledDrive driven({});
  driven.drive_on(20);
  const std::size_t before = driven.samples();
  driven.set_beams(38);
  driven.sample();
  EXPECT_EQ(driven.samples(), before);
  driven.set_beams(47);
  driven.sample();
  EXPECT_EQ(driven.samples(), before + 1);
}

TEST(SecondaryLasers, AreUsedNoMoreWhenSamplesContradictEachOther) {
  SampledDrive driven({});
  driven.drive_on(40);
  SecondaryLaser one = driven.laser();
  ASSERT_TRUE(one.is_used);
  std::vector<ExtrinsicSample> samples;
  for (int i = 0; i < 120; ++i) {  // of a mount that is turned
    samples.push_back({{0.1 * std::sin(i), 0.1 * std::cos(1.7 * i), 0.06 * std::sin(2.3 * i)},
                       covariance_of(0.001, 0.001),
                       kAtRest});
  }
  one.mount = ExtrinsicCalibration(samples);
  ASSERT_TRUE(one.mount.is_contradictory());
  SampledDrive turned({}, {}, one);
  turned.drive_on(5);
  EXPECT_FALSE(turned.laser().is_used);
}

}  // namespace
}  // namespace matchbox_slam
