#include "node/skip_warnings.hpp"

#include <ros/console.h>

namespace matchbox_slam {

void SkipWarnings::tell(ScanQueue& queue) {
  constexpr double kInterval = 10.0;  // s
  for (const std::string& news : queue.take_news()) {
    ROS_WARN_STREAM(news);
  }
  for (const SkippedScan& skipped : queue.take_skipped()) {
    latest_ = skipped.text;
    const ros::WallTime now = ros::WallTime::now();
    const auto last = told_.find(skipped.reason);
    if (last != told_.end() && (now - last->second).toSec() < kInterval) {
      continue;
    }
    told_[skipped.reason] = now;
    ROS_WARN_STREAM(skipped.text << " (" << queue.account().skipped_total() << " of "
                                 << queue.account().received << " scans skipped so far)");
  }
}

}  // namespace matchbox_slam
