// Of ros/scan_queue.hpp: several lasers.

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "ros/scan_feed.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {
namespace {

ScanQueueSettings two_lasers(std::optional<int> join_parts = 1) {
  ScanQueueSettings result = settings(join_parts);
  result.lasers = 2;
  return result;
}

TEST(ScanQueue, MergesScansOfSeveralLasersByTheirStamps) {
  Feed feed(two_lasers());
  feed.robot_until(110.0, 100.5);
  feed.scan_of(0, 101.0, 101.0);
  EXPECT_EQ(feed.ready(), Stamps{}) << "the other laser may have an earlier one";
  feed.scan_of(1, 100.9, 101.1);  // slower to arrive
  feed.scan_of(0, 101.1, 101.2);
  EXPECT_EQ(feed.ready(), (Stamps{100.9}));
  feed.scan_of(1, 101.05, 101.25);
  feed.scan_of(0, 101.2, 101.3);
  feed.scan_of(1, 101.15, 101.35);
  EXPECT_EQ(feed.ready(), (Stamps{101.0, 101.05, 101.1, 101.15}));
}

/// Two lasers, of which the second is slow to arrive, before and after their stamps jump back by
/// 54 s; the time of arrival does so, too, or goes on.
void feed_time_jump(double slow, bool arrivals_jump, Feed& feed) {
  struct Message {
    double arrival;
    int laser;  ///< -1: odometry
    double stamp;
  };
  std::vector<Message> messages;
  for (int k = 0; k < 80; ++k) {
    const double arrival = 100.0 + 0.1 * k;
    const double stamp = k < 40 ? arrival : arrival - 54.0;
    messages.push_back({arrival, -1, stamp});
    messages.push_back({arrival + 0.01, 0, stamp});
    messages.push_back({arrival + 0.01 + slow, 1, stamp + 0.03});
    messages.push_back({arrival + slow, -1, stamp + 0.05});
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const Message& a, const Message& b) { return a.arrival < b.arrival; });
  for (const Message& message : messages) {
    const double now = message.arrival - (arrivals_jump && message.arrival > 103.999 ? 54.0 : 0.0);
    if (message.laser < 0) {
      feed.odometry_at(message.stamp, now);
    } else {
      feed.scan_of(message.laser, message.stamp, now);
    }
  }
}

TEST(ScanQueue, ATimeJumpIsOneWithASlowLaserToo) {
  for (const bool arrivals_jump : {false, true}) {
    for (const double slow : {0.02, 0.15, 0.35}) {
      Feed feed(two_lasers(std::nullopt));
      feed.laser();
      feed_time_jump(slow, arrivals_jump, feed);
      const Stamps ready = feed.ready();
      const std::string account = to_string(feed.queue.account()) + " " + std::to_string(slow);
      EXPECT_EQ(std::count_if(ready.begin(), ready.end(), [](double s) { return s < 0.0; }), 1)
          << account;
      EXPECT_GE(feed.queue.account().delivered, 146U) << account;
    }
  }
}

/// Scans of two lasers, 0.1 s apart; `second` gives the other's.
template <typename Second>
void feed_both(int scans, Feed& feed, const Second& second) {
  feed.robot_until(120.0, 100.5);
  for (int k = 0; k < scans; ++k) {
    const double stamp = 101.0 + 0.1 * k;
    feed.scan_of(0, stamp, stamp + 0.01);
    second(k, stamp);
  }
  feed.queue.finish();
}

TEST(ScanQueue, ScansOfALaserThatComeLateAllAtOnceAreNoTimeJump) {
  Feed feed(two_lasers());
  feed_both(80, feed, [&](int k, double stamp) {
    const int first = k == 59 ? 40 : k;  // two seconds at once
    for (int late = first; late <= k && (k < 40 || k >= 59); ++late) {
      feed.scan_of(1, 101.03 + 0.1 * late, stamp + 0.05);
    }
  });
  const Stamps ready = feed.ready();
  EXPECT_EQ(std::count_if(ready.begin(), ready.end(), [](double s) { return s < 0.0; }), 0);
  EXPECT_EQ(feed.skipped(SkipReason::kTimeJump), 0U);
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), feed.queue.account().skipped_total());
  EXPECT_LE(feed.queue.account().skipped_total(), 20U) << "what came late alone";
}

TEST(ScanQueue, AStampFarAheadDoesNotHaveALaserWaitedForNoMore) {
  Feed feed(two_lasers());
  feed_both(50, feed, [&](int k, double stamp) {  // slower to arrive
    feed.scan_of(1, stamp - 0.02 + (k == 10 ? 86400.0 : 0.0), stamp + 0.06);
  });
  EXPECT_EQ(feed.ready().size(), 99U);
  EXPECT_EQ(feed.queue.account().skipped_total(), 1U);
}

TEST(ScanQueue, AScanBehindOneThatWaitedForTheNextIsNotTooLateForThat) {
  ScanQueueSettings hurried = two_lasers(std::nullopt);
  hurried.max_lag = 0.02;
  Feed feed(hurried);
  feed.robot_until(110.0, 100.5);
  for (const double stamp : {101.0, 101.1}) {
    feed.scan_of(0, stamp, stamp);
    feed.scan_of(1, stamp + 0.01, stamp + 0.01);
  }
  feed.queue.finish();
  EXPECT_EQ(feed.ready(), (Stamps{101.0, 101.01, 101.1, 101.11}));
}

TEST(ScanQueue, LasersMayHaveTheSameStamps) {
  Feed feed(two_lasers(std::nullopt));
  feed.robot_until(110.0, 100.5);
  for (const double stamp : {101.0, 101.1}) {
    feed.scan_of(1, stamp, stamp);
    feed.scan_of(0, stamp, stamp);
  }
  feed.scan_of(0, 101.1, 101.2);  // once more
  EXPECT_EQ(feed.ready().size(), 4U);
  EXPECT_EQ(feed.queue.account().skipped_total(), 1U);
}

TEST(ScanQueue, ALaserThatFallsSilentHoldsTheOthersUpForAMoment) {
  Feed feed(two_lasers());
  feed.robot_until(110.0, 100.5);
  feed.scan_of(0, 101.0, 101.0);
  feed.scan_of(1, 101.0, 101.0);
  feed.scan_of(0, 101.1, 101.1);
  EXPECT_EQ(feed.ready(), (Stamps{101.0, 101.0}));
  feed.scan_of(0, 101.2, 101.7);  // the other one may have stopped
  EXPECT_EQ(feed.ready(), (Stamps{101.1}));
  feed.scan_of(0, 101.8, 102.3);
  feed.scan_of(0, 101.9, 102.4);
  EXPECT_EQ(feed.ready(), (Stamps{101.2, 101.8, 101.9})) << "it is not waited for any more";
}

}  // namespace
}  // namespace matchbox_slam
