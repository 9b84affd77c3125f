#pragma once

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {

/// Which points of a cloud make a scan: those of one ring, or else of a band of heights. All is in
/// the cloud's own frame, whose z axis points up. Names are those that users know from
/// pointcloud_to_laserscan, where the meaning is.
struct CloudOptions {
  int ring = -1;
  double min_height = -0.2;
  double max_height = 0.2;
  double angle_min = -kPi;
  double angle_max = kPi;
  double angle_increment = degrees_to_radians(0.25);
  double range_min = 0.1;
  double range_max = 100.0;
  double scan_time = 0.0;
  bool clear_empty = false;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.ring, "ring", between(-1, 65535), "",
           "Takes the points whose field ring says this; -1: those of a band of heights.");
    option(self.min_height, "min_height", between(-1e3, 1e3), "m",
           "Lowest z of the points taken, in the cloud's own frame; without ring.");
    option(self.max_height, "max_height", between(-1e3, 1e3), "m", "Highest z of them.");
    option(self.angle_min, "angle_min", between(-2.0 * kPi, 2.0 * kPi), "rad",
           "Where the first beam points, in the cloud's own frame.");
    option(self.angle_max, "angle_max", between(-2.0 * kPi, 2.0 * kPi), "rad",
           "Where the last one points, at most a turn later.");
    option(self.angle_increment, "angle_increment", between(1e-4, 0.5), "rad",
           "From beam to beam; each gets the nearest of the points around it.");
    option(self.range_min, "range_min", between(0.0, 1e3), "m",
           "Points nearer than this are left out; distances are horizontal.");
    option(self.range_max, "range_max", between(0.0, 1e4), "m",
           "Points as far as this are left out.");
    option(
        self.scan_time, "scan_time", between(-10.0, 10.0), "s",
        "From the first beam, which the stamp tells, to the last; below 0 for a laser that turns "
        "clockwise; 0: all points are of one moment.");
    option(self.clear_empty, "clear_empty", any(), "",
           "Whether a beam without points clears the map up to scan/free_range, for clouds that "
           "leave out only what has no return; else nothing is known there.");
  }
};

/// Reads the section `cloud`. Throws ConfigurationError, also for a band, a sector or a reach that
/// holds nothing.
[[nodiscard]] CloudOptions read_cloud_options(const Parameters& parameters);

/// The options by their full names.
[[nodiscard]] std::vector<OptionDescription> describe_cloud_options(const CloudOptions& options);

}  // namespace matchbox_slam
