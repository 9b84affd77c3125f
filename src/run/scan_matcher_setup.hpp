#pragma once

#include <memory>
#include <string>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/odometry/laser_odometry.hpp"
#include "run/cloud_options.hpp"
#include "run/matcher_catalog.hpp"
#include "run/shared_run_options.hpp"
#include "sensor/scan_timing.hpp"

namespace matchbox_slam {

/// What concerns the laser odometry node besides laser odometry itself.
struct ScanMatcherNodeOptions : SharedRunOptions {
  bool publish_tf = true;
  std::string guess = "velocity";
  std::string guess_frame;
  double scan_time_offset = 0.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    visit_matcher(self, option);
    option(self.seed, "seed", at_least(0.0), "",
           "Of the random numbers; the same seed gives the same odometry.");
    option(self.base_frame, "base_frame", any(), "",
           "Frame of the robot whose motion is estimated.");
    option(self.odom_frame, "odom_frame", any(), "",
           "Frame of the odometry that is published, its origin where the first scan was.");
    option(self.publish_tf, "publish_tf", any(), "",
           "Whether to publish the transform odom_frame -> base_frame (odom_frame -> guess_frame "
           "when odometry gives the guess, since base_frame is below that already).");
    option(self.guess, "guess", one_of({"velocity", "odometry", "imu"}), "",
           "Where each match starts: the last motion goes on; or odometry in tf, from guess_frame "
           "to base_frame; or the last motion with the turn by the yaw on the topic imu.");
    option(self.guess_frame, "guess_frame", any(), "",
           "Frame in which the odometry moves that gives the guess, with guess 'odometry' only.");
    option(self.transform_timeout, "transform_timeout", between(0.0, 3600.0), "s",
           "A scan waits this long for its transforms and its guess, then it is skipped.");
    visit_queue_size(self, option);
    option(self.scan_time_offset, "scan_time_offset", between(-1e6, 1e6), "s",
           "Added to the stamps of scans, whose clock may differ from that of tf and IMU.");
  }
};

/// A configuration of the laser odometry node as it takes effect.
struct ScanMatcherSetup {
  ScanMatcherNodeOptions node;
  CloudOptions cloud;
  ScanTimingOptions timing;
  GuessSource guess = GuessSource::kVelocity;
  LaserOdometrySettings odometry;
  std::string matcher_name;  ///< lookup name
  std::shared_ptr<const ScanMatcher> matcher;

  /// The frame whose place in `odom_frame` tf tells, as the child of that link.
  [[nodiscard]] const std::string& tf_child() const {
    return guess == GuessSource::kOdometry ? node.guess_frame : node.base_frame;
  }
};

/// Reads the keys of ScanMatcherNodeOptions, the sections of laser odometry, and one section a
/// matcher, of which only the chosen one's takes effect. Frames come without their leading slash.
/// Throws ConfigurationError for an unknown key, section or matcher, for a bad value, and for
/// frames that do not fit together.
[[nodiscard]] ScanMatcherSetup make_scan_matcher_setup(const Parameters& parameters,
                                                       const MatcherCatalog& catalog);

}  // namespace matchbox_slam
