#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "ros/messages.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {

/// @param join_parts  none, as by default: the first scan of a laser waits for its next, too.
inline ScanQueueSettings settings(std::optional<int> join_parts = 1) {
  ScanQueueSettings settings;
  settings.timing.join_parts = join_parts;
  settings.base_frame = "base";
  settings.odom_frame = "odom";
  settings.map_frame = "map";
  return settings;
}

/// A queue that is fed by stamps and asked for the stamps that come out. In the end each scan has
/// to be accounted for.
class Feed {
 public:
  explicit Feed(const ScanQueueSettings& settings) : queue(settings) {}
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;
  ~Feed() {
    const ScanAccount& account = queue.account();
    EXPECT_EQ(account.received, account.delivered + account.skipped_total() + queue.waiting());
  }

  void scan(double stamp) { scan_at(stamp, stamp); }
  void scan_at(double stamp, double now) { queue.add_scan(make_scan(stamp), ros::Time(now)); }

  void scan_of(int laser, double stamp, double now) {
    queue.add_scan(make_scan(stamp), ros::Time(now), laser);
  }

  void odometry(double stamp) { odometry_at(stamp, stamp); }
  void odometry_at(double stamp, double now) {
    queue.add_transforms(make_link(stamp, "odom", "base", stamp), false, ros::Time(now));
  }
  void laser() {
    queue.add_transforms(make_link(0.0, "base", "laser", 0.2), true, ros::Time(100.0));
  }

  /// The laser's place, and odometry from 100 s to a stamp, which is there by `now`.
  void robot_until(double stamp) { robot_until(stamp, stamp); }
  void robot_until(double stamp, double now) {
    laser();
    odometry(100.0);
    odometry_at(stamp, now);
  }

  std::vector<double> ready() {
    std::vector<double> stamps;
    while (const auto item = queue.next()) {
      if (std::holds_alternative<LeftOut>(*item)) {
        continue;
      }
      const auto* scan = std::get_if<ReadyScan>(&*item);
      stamps.push_back(scan != nullptr ? scan->stamp.toSec() : -std::get<TimeJump>(*item).seconds);
    }
    return stamps;
  }

  [[nodiscard]] std::size_t skipped(SkipReason reason) const {
    const auto found = queue.account().skipped.find(reason);
    return found == queue.account().skipped.end() ? 0 : found->second;
  }

  ScanQueue queue;
};

using Stamps = std::vector<double>;

inline const ScanInput& input_of(const ScanQueue::Item& item) {
  return std::get<ReadyScan>(item).input;
}

}  // namespace matchbox_slam
