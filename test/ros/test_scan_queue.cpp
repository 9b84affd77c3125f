#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "common/error_text.hpp"
#include "ros/messages.hpp"
#include "ros/scan_feed.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {
namespace {

TEST(ScanQueue, WaitsUntilTransformsCoverTheScan) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.scan(100.5);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.odometry(100.4);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.odometry(100.6);
  EXPECT_EQ(feed.ready(), Stamps{100.5});
}

TEST(ScanQueue, WaitsForTheLastBeam) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  sensor_msgs::LaserScan scan = make_scan(100.5);
  scan.time_increment = 0.002F;  // 0.178 s in all
  feed.queue.add_scan(scan, ros::Time(100.7));
  feed.odometry(100.6);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.odometry(100.7);
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const ScanInput& input = std::get<ReadyScan>(*item).input;
  EXPECT_NEAR(input.odometry->odom_from_base.x, 100.5, 1e-9);
  EXPECT_NEAR(input.odometry->odom_from_base_last_beam.x, 100.678, 1e-6);
  EXPECT_NEAR(input.base_from_laser.translation().x(), 0.2, 1e-12);
}

TEST(ScanQueue, TheResultDoesNotDependOnHowMessagesInterleave) {
  Feed late_scans(settings(std::nullopt));
  Feed late_transforms(settings(std::nullopt));
  for (Feed* feed : {&late_scans, &late_transforms}) {
    feed->laser();
  }
  for (int k = 0; k < 20; ++k) {
    late_scans.odometry_at(100.0 + 0.07 * k, 100.0 + 0.07 * k);
    late_transforms.scan_at(100.05 + 0.05 * k, 100.05 + 0.05 * k);
  }
  for (int k = 0; k < 20; ++k) {
    late_scans.scan_at(100.05 + 0.05 * k, 101.4 + 0.05 * k);
    late_transforms.odometry_at(100.0 + 0.07 * k, 101.05 + 0.05 * k);
  }
  const Stamps stamps = late_scans.ready();
  EXPECT_EQ(stamps.size(), 20U);
  EXPECT_EQ(late_transforms.ready(), stamps);
}

TEST(ScanQueue, SkipsAScanWithoutTransformAfterTheTimeout) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.scan(100.5);
  feed.odometry_at(100.2, 102.4);
  EXPECT_TRUE(feed.queue.take_skipped().empty());
  feed.odometry_at(100.3, 102.6);
  const std::vector<SkippedScan> skipped = feed.queue.take_skipped();
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_EQ(skipped[0].reason, SkipReason::kNoTransform);
  EXPECT_EQ(skipped[0].text,
            "scan of 100.500 s skipped (no_transform): no transform from 'base' to 'odom' at "
            "100.500: the newest is 0.200 s older");
}

TEST(ScanQueue, SkipsScansWhenItsFramesAreSwapped) {
  ScanQueueSettings swapped = settings();
  std::swap(swapped.base_frame, *swapped.odom_frame);
  Feed feed(swapped);
  feed.laser();
  feed.odometry(100.0);
  feed.scan(100.0);
  EXPECT_EQ(feed.ready(), Stamps{});
  const std::vector<SkippedScan> skipped = feed.queue.take_skipped();
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_EQ(skipped[0].text,
            "scan of 100.000 s skipped (no_transform): odometry frame 'base' lies below base frame "
            "'odom' in tf; are the two swapped?");
}

TEST(ScanQueue, WaitingScansAreSkippedAtTheEnd) {
  Feed feed(settings());
  feed.scan(100.0);
  feed.queue.finish();
  EXPECT_EQ(feed.ready(), Stamps{});
  EXPECT_EQ(feed.skipped(SkipReason::kNoTransform), 1U);
}

TEST(ScanQueue, BringsWaitingScansIntoOrder) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.scan_at(100.3, 100.4);
  feed.scan_at(100.2, 100.4);
  feed.odometry(100.5);
  EXPECT_EQ(feed.ready(), (Stamps{100.2, 100.3}));
}

TEST(ScanQueue, CountsDuplicatesAndScansThatComeTooLate) {
  Feed feed(settings());
  feed.robot_until(101.0);
  for (const double stamp : {100.5, 100.5, 100.4, 100.6}) {
    feed.scan_at(stamp, 101.0);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.5, 100.6}));
  EXPECT_EQ(feed.skipped(SkipReason::kDuplicateStamp), 1U);
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 1U);
}

TEST(ScanQueue, CountsScansThatAreNone) {
  Feed feed(settings());
  sensor_msgs::LaserScan scan = make_scan(100.0);
  scan.ranges.clear();
  feed.queue.add_scan(scan, ros::Time(100.0));
  scan = make_scan(100.1);
  scan.angle_increment = 0.0F;
  feed.queue.add_scan(scan, ros::Time(100.1));
  EXPECT_EQ(feed.skipped(SkipReason::kEmpty), 1U);
  EXPECT_EQ(feed.skipped(SkipReason::kInvalid), 1U);
  EXPECT_TRUE(contains(feed.queue.take_skipped().at(1).text, "angle_increment is 0"));
}

TEST(ScanQueue, SkipsScansThatWouldBeTornOverTheMap) {
  Feed feed(settings());
  feed.queue.add_transforms(make_link(0.0, "base", "laser", 1001.0), true, ros::Time(100.0));
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.5, 101.0);
  EXPECT_TRUE(contains(feed.queue.take_skipped().at(0).text, "m from the base; allowed: up to"));
  feed.laser();
  sensor_msgs::LaserScan scan = make_scan(101.5);
  scan.time_increment = 0.002F;  // 0.178 s in all
  feed.queue.add_scan(scan, ros::Time(101.7));
  feed.queue.add_transforms(make_link(102.0, "odom", "base", 9e6), false, ros::Time(102.0));
  EXPECT_TRUE(contains(feed.queue.take_skipped().at(0).text, "while it is taken"));
  EXPECT_EQ(feed.ready(), Stamps{});
  EXPECT_EQ(feed.skipped(SkipReason::kInvalid), 2U);
}

TEST(ScanQueue, TheFrameMayChangeFromScanToScan) {
  Feed feed(settings());
  feed.laser();
  feed.queue.add_transforms(make_link(0.0, "base", "other", -0.3), true, ros::Time(100.0));
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.5, 101.0);
  feed.queue.add_scan(make_scan(100.6, "/other", 17), ros::Time(101.0));
  (void)feed.queue.next();
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const auto& scan = std::get<ReadyScan>(*item);
  EXPECT_EQ(scan.frame, "other");
  EXPECT_NEAR(scan.input.base_from_laser.translation().x(), -0.3, 1e-12);
  EXPECT_EQ(scan.input.scan.ranges.size(), 17U);
}

TEST(ScanQueue, WithoutOdometryTheLaserIsEnough) {
  ScanQueueSettings without = settings();
  without.odom_frame.reset();
  without.base_frame = "laser";
  Feed feed(without);
  feed.scan(100.0);
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const ScanInput& input = std::get<ReadyScan>(*item).input;
  EXPECT_FALSE(input.odometry);
  EXPECT_TRUE(input.base_from_laser.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(ScanQueue, AddsTheOffsetToTheStampsOfScans) {
  ScanQueueSettings offset = settings();
  offset.scan_time_offset = ros::Duration(82.5);
  Feed feed(offset);
  feed.laser();
  feed.odometry(182.0);
  feed.odometry(183.0);
  feed.scan_at(100.0, 183.0);
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  EXPECT_DOUBLE_EQ(std::get<ReadyScan>(*item).input.scan.stamp, 182.5);
  offset.scan_time_offset = ros::Duration(-200.0);
  Feed before_time(offset);
  before_time.scan(100.0);
  EXPECT_EQ(before_time.skipped(SkipReason::kInvalid), 1U);
}

TEST(ScanQueue, ATransformBeforeSimulatedTimeBeginsCostsNoScan) {
  Feed feed(settings());
  feed.queue.add_transforms(make_link(0.0, "base", "laser", 0.2), true, ros::Time());
  feed.scan_at(1000.1, 0.0);
  feed.odometry(1000.0);
  feed.odometry(1000.2);
  EXPECT_EQ(feed.ready(), Stamps{1000.1});
}

TEST(ScanQueue, GivesUpScansThatWaitedTooLongButNeverTheNewest) {
  ScanQueueSettings slow = settings();
  slow.max_lag = 0.25;
  Feed feed(slow);
  feed.robot_until(110.0, 100.5);
  for (const double stamp : {101.0, 101.1, 101.2, 101.3, 101.4}) {
    feed.scan(stamp);
  }
  EXPECT_EQ(feed.ready(), (Stamps{101.2, 101.3, 101.4}));
  EXPECT_EQ(feed.skipped(SkipReason::kTooLate), 2U);
  feed.scan_at(101.5, 105.0);
  feed.odometry_at(111.0, 105.5);
  EXPECT_EQ(feed.ready(), (Stamps{101.5})) << "late, but there is nothing newer";
}

TEST(ScanQueue, InThePlaceOfAScanThatItHadNoTimeForItSaysThat) {
  ScanQueueSettings slow = settings();
  slow.max_lag = 0.25;
  Feed feed(slow);
  feed.robot_until(110.0, 100.5);
  for (const double stamp : {101.0, 101.1, 101.4}) {
    feed.scan(stamp);
  }
  const auto first = feed.queue.next();
  const auto second = feed.queue.next();
  const auto third = feed.queue.next();
  ASSERT_TRUE(first && second && third);
  EXPECT_EQ(std::get<LeftOut>(*first).stamp, 101.0);
  EXPECT_EQ(std::get<LeftOut>(*second).stamp, 101.1);
  EXPECT_TRUE(std::holds_alternative<ReadyScan>(*third));
}

TEST(ScanQueue, NeverHoldsMoreThanItMay) {
  ScanQueueSettings small = settings();
  small.max_waiting = 3;
  Feed feed(small);
  for (int k = 0; k < 10; ++k) {
    feed.scan_at(100.0 + 0.1 * k, 100.0);
  }
  EXPECT_EQ(feed.queue.waiting(), 3U);
  EXPECT_EQ(feed.skipped(SkipReason::kQueueFull), 7U);
  feed.robot_until(101.0);
  EXPECT_EQ(feed.queue.waiting(), 3U);
  feed.scan_at(100.95, 101.0);
  EXPECT_EQ(feed.queue.waiting(), 3U);
  EXPECT_EQ(feed.ready(), (Stamps{100.8, 100.9, 100.95})) << "the newest are kept";
}

/// Parts of turns of a laser that turns ten times a second, a quarter of a turn each.
std::vector<sensor_msgs::LaserScan> parts_from(double first, int count) {
  std::vector<sensor_msgs::LaserScan> parts;
  for (int k = 0; k < count; ++k) {
    sensor_msgs::LaserScan part = make_scan(first + 0.025 * k, "laser", 90);
    part.angle_increment = static_cast<float>(2.0 * kPi / 360.0);
    part.angle_min = static_cast<float>(0.5 * kPi * k);
    parts.push_back(part);
  }
  return parts;
}

TEST(ScanQueue, CountsPartsOfATurnAsOneScan) {
  Feed feed(settings(std::nullopt));
  feed.robot_until(102.0, 100.4);
  for (const sensor_msgs::LaserScan& part : parts_from(100.5, 11)) {
    feed.queue.add_scan(part, part.header.stamp);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.5, 100.6}));
  EXPECT_EQ(feed.queue.account().received, 2U);
  EXPECT_EQ(feed.queue.take_news().size(), 1U);
  feed.queue.finish();
  EXPECT_EQ(feed.ready(), Stamps{100.7});
  EXPECT_EQ(feed.queue.account().received, 3U);
}

TEST(ScanQueue, AScanThatWaitedForTheNextIsNotTooLateForThat) {
  ScanQueueSettings hurried = settings(std::nullopt);
  hurried.max_lag = 0.02;
  Feed feed(hurried);
  feed.robot_until(102.0, 100.4);
  feed.scan(100.5);
  feed.scan(100.55);
  EXPECT_EQ(feed.ready(), (Stamps{100.5, 100.55}));
}

TEST(ScanQueue, TheFirstScanWaitsForTheNextToTellWhetherItIsAPart) {
  Feed feed(settings(std::nullopt));
  feed.robot_until(102.0, 100.4);
  feed.scan(100.5);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.scan(100.6);
  EXPECT_EQ(feed.ready(), (Stamps{100.5, 100.6}));
  feed.scan(100.7);
  EXPECT_EQ(feed.ready(), Stamps{100.7});
}

/// Where odometry has the first scan of a robot that turns by so much from scan to scan.
Pose2 first_pose(std::optional<int> join_parts, double turn) {
  Feed feed(settings(join_parts));
  feed.laser();
  for (int k = 0; k < 4; ++k) {
    const double stamp = 100.0 + 0.1 * k;
    feed.queue.add_transforms(make_link(stamp, "odom", "base", 0.3 * k, 0.2 + turn * k), false,
                              ros::Time(stamp));
    if (k >= 2) {
      feed.scan(stamp);
    }
  }
  const auto first = feed.queue.next();
  return first ? input_of(*first).odometry->odom_from_base : Pose2();
}

TEST(ScanQueue, TheFirstScanIsPlacedToTheBitAsIfItDidNotWait) {
  for (int k = 1; k <= 50; ++k) {
    const Pose2 pose = first_pose(std::nullopt, 0.02 * k);
    EXPECT_EQ(pose.x, 0.6);
    EXPECT_EQ(pose.theta, first_pose(1, 0.02 * k).theta) << k;
  }
}

TEST(ScanQueue, AFullCircleIsNoPartAndWaitsForNothing) {
  Feed feed(settings(std::nullopt));
  feed.robot_until(102.0, 100.4);
  sensor_msgs::LaserScan scan = make_scan(100.5, "laser", 360);
  scan.angle_increment = static_cast<float>(2.0 * kPi / 360.0);
  feed.queue.add_scan(scan, ros::Time(100.5));
  EXPECT_EQ(feed.ready(), Stamps{100.5});
}

TEST(ScanQueue, AFirstScanThatStaysAloneIsUsed) {
  for (const bool is_end : {false, true}) {
    SCOPED_TRACE(is_end ? "at the end" : "after a while");
    Feed feed(settings(std::nullopt));
    feed.laser();
    feed.odometry(100.0);
    feed.scan(100.5);
    feed.odometry(100.6);
    EXPECT_EQ(feed.ready(), Stamps{});
    if (is_end) {
      feed.queue.finish();
    } else {
      feed.odometry(101.1);
    }
    EXPECT_EQ(feed.ready(), Stamps{100.5});
  }
}

TEST(ScanQueue, AFirstPartThatWasUsedAloneIsNotUsedAgain) {
  Feed feed(settings(std::nullopt));
  feed.laser();
  feed.odometry(100.0);
  const std::vector<sensor_msgs::LaserScan> parts = parts_from(100.5, 8);
  feed.queue.add_scan(parts.front(), ros::Time(100.5));
  feed.odometry_at(102.0, 101.1);
  EXPECT_EQ(feed.ready(), Stamps{100.5});
  for (std::size_t k = 1; k < parts.size(); ++k) {
    feed.queue.add_scan(parts[k], ros::Time(101.1));
  }
  EXPECT_EQ(feed.ready(), Stamps{100.6});
  EXPECT_EQ(feed.skipped(SkipReason::kDuplicateStamp), 1U);
}

TEST(ScanQueue, SkipsPartsWhoseTurnWasCutOffByATimeJump) {
  Feed feed(settings(std::nullopt));
  feed.robot_until(102.0, 100.4);
  for (const sensor_msgs::LaserScan& part : parts_from(100.5, 7)) {
    feed.queue.add_scan(part, part.header.stamp);
  }
  EXPECT_EQ(feed.ready().size(), 1U);
  feed.queue.add_transforms(make_link(50.0, "odom", "base", 1.0), false, ros::Time(50.0));
  EXPECT_EQ(feed.skipped(SkipReason::kTimeJump), 1U);
  EXPECT_EQ(feed.queue.account().received, 2U);
}

TEST(ScanQueue, SkipsPartsThatWaitWhenTheRunIsEnded) {
  Feed feed(settings(std::nullopt));
  for (const sensor_msgs::LaserScan& part : parts_from(100.5, 3)) {
    feed.queue.add_scan(part, part.header.stamp);
  }
  feed.queue.interrupt();
  EXPECT_EQ(feed.skipped(SkipReason::kInterrupted), 1U);
}

/// A laser that turns all round and tells no times, whose odometry is not known where it is asked
/// for between scans.
TEST(ScanQueue, LooksForNoSweepTimeWhereOdometryIsNotKnown) {
  Feed feed(settings());
  feed.laser();
  for (int k = 0; k < 6; ++k) {
    const double stamp = 100.0 + 100.0 * k;  // tf keeps 60 s
    sensor_msgs::LaserScan scan = make_scan(stamp, "laser", 360);
    scan.angle_increment = static_cast<float>(2.0 * kPi / 360.0);
    for (const double at : {stamp - 0.1, stamp, stamp + 0.1}) {
      feed.queue.add_transforms(make_link(at, "odom", "base", 0.1 * at, at), false,
                                ros::Time(stamp));
    }
    feed.queue.add_scan(scan, ros::Time(stamp));
  }
  EXPECT_EQ(feed.ready().size(), 6U);
  EXPECT_TRUE(feed.queue.take_news().empty());
}

}  // namespace
}  // namespace matchbox_slam
