#pragma once

#include <string>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

/// What mapping and laser odometry are both asked, and the one home of these defaults. Rows that
/// read alike are here, too.
struct SharedRunOptions {
  std::string matcher = "olson";
  int seed = 1;
  std::string base_frame = "base_link";
  std::string odom_frame = "odom";
  double transform_timeout = 2.0;
  int queue_size = 2000;

  template <typename Self, typename Visitor>
  static void visit_matcher(Self& self, Visitor&& option) {
    option(self.matcher, "matcher", any(), "",
           "Scan matcher: a plugin's short name such as olson, or its lookup name such as "
           "matchbox_slam/Olson.");
  }
  template <typename Self, typename Visitor>
  static void visit_queue_size(Self& self, Visitor&& option) {
    option(self.queue_size, "queue_size", between(1, 1e6), "",
           "Scans that may wait; beyond, the oldest are skipped.");
  }
};

}  // namespace matchbox_slam
