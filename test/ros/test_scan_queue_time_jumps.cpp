// Of ros/scan_queue.hpp: clocks that jump, and events between scans.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "ros/scan_feed.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {
namespace {

TEST(ScanQueue, StartsAnewWhenTheClockJumpsBack) {
  Feed feed(settings());
  feed.laser();
  for (const double begin : {100.0, 50.0}) {
    feed.odometry(begin);
    feed.scan(begin + 0.1);
    feed.odometry(begin + 0.2);
  }
  feed.scan(50.3);
  EXPECT_EQ(feed.ready(), (Stamps{100.1, -50.2, 50.1}));
}

TEST(ScanQueue, StartsAnewWhenStampsJumpBack) {
  Feed feed(settings());
  feed.laser();
  feed.odometry_at(100.0, 200.0);
  feed.odometry_at(100.2, 200.0);
  feed.scan_at(100.1, 200.0);
  for (const double stamp : {50.1, 50.2, 50.3}) {
    feed.scan_at(stamp, 200.1);
  }
  feed.odometry_at(50.0, 200.2);
  feed.odometry_at(50.4, 200.3);
  EXPECT_EQ(feed.ready(), (Stamps{100.1, -49.8, 50.3}));
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 2U) << "the two before it was certain";
}

TEST(ScanQueue, SingleScansWithAnOldStampAreNoTimeJump) {
  Feed feed(settings());
  feed.laser();
  feed.odometry_at(100.0, 200.0);
  feed.odometry_at(110.0, 200.0);
  for (const double stamp :
       {100.1, 50.1, 100.2, 50.2, 50.3, 100.3, 50.4, 50.4, 50.3, 50.2, 100.4}) {
    feed.scan_at(stamp, 200.0);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.1, 100.2, 100.3, 100.4}));
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 7U);
}

TEST(ScanQueue, AScanWithAStampFarAheadIsNoTimeJump) {
  ScanQueueSettings without = settings();
  without.odom_frame.reset();
  without.base_frame = "laser";
  Feed feed(without);
  feed.scan_at(100.0, 200.0);
  feed.scan_at(3.9e9, 200.1);
  for (const double stamp : {100.1, 100.2, 100.3, 100.4}) {
    feed.scan_at(stamp, stamp + 100.0);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.0, 100.1, 100.2, 100.3, 100.4}));
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 1U);
  for (const double stamp : {5000.0, 5000.1, 5000.2}) {  // another clock
    feed.scan_at(stamp, 300.0);
  }
  EXPECT_EQ(feed.ready(), Stamps{5000.2});
}

TEST(ScanQueue, TimesAreComparedAcrossAllThatAStampCanHold) {
  Feed feed(settings());
  feed.scan_at(1.0, 4e9);
  feed.scan_at(4e9, 4e9);
  feed.scan_at(2.0, 1.0);
  feed.queue.finish();
}

TEST(ScanQueue, CountsWhatAResetDiscards) {
  Feed feed(settings());
  feed.robot_until(101.0);
  feed.scan_at(100.1, 101.0);
  feed.scan_at(100.2, 101.0);
  feed.queue.discard_delivered();
  EXPECT_EQ(feed.skipped(SkipReason::kBeforeReset), 0U) << "they wait to be delivered";
  EXPECT_EQ(feed.ready(), (Stamps{100.1, 100.2}));
  feed.queue.discard_delivered();
  EXPECT_EQ(feed.skipped(SkipReason::kBeforeReset), 2U);
  EXPECT_EQ(feed.queue.account().delivered, 0U);
}

TEST(ScanQueue, CountsAScanThatIsLeftOutWhilePaused) {
  Feed feed(settings());
  feed.robot_until(101.0);
  feed.scan_at(100.1, 101.0);
  feed.scan_at(100.2, 101.0);
  const auto first = feed.queue.next();
  ASSERT_TRUE(first);
  feed.queue.leave_out(std::get<ReadyScan>(*first));
  EXPECT_EQ(feed.ready(), Stamps{100.2});
  EXPECT_EQ(feed.skipped(SkipReason::kPaused), 1U);
  EXPECT_EQ(feed.queue.account().delivered, 1U);
}

/// For each item, its stamp, or the place of its kind among RunEvent's with a minus sign.
std::vector<double> order_of_items(ScanQueue& queue) {
  std::vector<double> order;
  while (const auto item = queue.next()) {
    if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
      order.push_back(scan->stamp.toSec());
    } else {
      order.push_back(-static_cast<double>(std::get<RunEvent>(*item).index()));
    }
  }
  return order;
}

TEST(ScanQueue, AnEventComesAfterTheScansThatWereReady) {
  Feed feed(settings());
  feed.robot_until(100.25);
  feed.scan_at(100.1, 100.3);
  feed.scan_at(100.2, 100.3);
  feed.scan_at(100.3, 100.3);  // its transforms come after the event
  feed.queue.add_event(Pause{true});
  feed.odometry_at(101.0, 100.4);
  EXPECT_EQ(order_of_items(feed.queue), (std::vector<double>{100.1, 100.2, -4.0, 100.3}));
}

TEST(ScanQueue, AnEventThatGivesUpTheMapWaitsForNoScan) {
  Feed feed(settings());
  feed.robot_until(101.0);
  feed.scan_at(100.1, 101.0);
  feed.queue.add_event(Pause{true});
  feed.scan_at(100.2, 101.0);
  feed.queue.add_event(Reset{});
  feed.scan_at(100.3, 101.0);
  EXPECT_EQ(order_of_items(feed.queue), (std::vector<double>{-4.0, -2.0, 100.3}));
  EXPECT_EQ(feed.skipped(SkipReason::kBeforeReset), 2U);
}

TEST(ScanQueue, AnInterruptLeavesNothingAndCountsAll) {
  Feed feed(settings());
  feed.robot_until(100.25);
  feed.scan_at(100.1, 100.3);
  feed.scan_at(100.2, 100.3);
  feed.scan_at(100.3, 100.3);  // without transforms
  ASSERT_TRUE(feed.queue.next());
  feed.queue.add_event(Pause{true});
  feed.queue.interrupt();
  EXPECT_FALSE(feed.queue.next());
  EXPECT_EQ(feed.queue.waiting(), 0U);
  EXPECT_EQ(feed.skipped(SkipReason::kInterrupted), 2U);
  EXPECT_EQ(feed.queue.account().delivered, 1U);
  EXPECT_EQ(to_string(feed.queue.account()),
            "3 scans received, 1 used, 2 skipped (interrupted: 2)");
}

TEST(ScanQueue, StopsWhenTimeJumpsBackIfAskedTo) {
  ScanQueueSettings stop = settings();
  stop.stop_at_time_jump = true;
  Feed feed(stop);
  feed.robot_until(100.2);
  feed.scan_at(100.1, 100.2);
  for (const double stamp : {50.1, 50.2, 50.3}) {
    feed.scan_at(stamp, 100.3);
  }
  const auto first = feed.queue.next();
  const auto second = feed.queue.next();
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(std::get<TimeJump>(*second).stopped);
  EXPECT_EQ(feed.skipped(SkipReason::kStopped), 1U);
  EXPECT_TRUE(feed.queue.stopped());
  feed.queue.start_again();
  EXPECT_FALSE(feed.queue.stopped());
  feed.odometry_at(50.0, 100.4);
  feed.odometry_at(51.0, 100.4);
  feed.scan_at(50.4, 100.4);
  EXPECT_EQ(feed.ready(), Stamps{50.4});
}

}  // namespace
}  // namespace matchbox_slam
