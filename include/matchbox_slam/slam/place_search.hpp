#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

struct RecoveryOptions {
  double interval = 0.1;
  int key_scans = 1;
  int confirmations = 4;
  int far_confirmations = 7;
  double least_score = 0.6;
  double distance = 0.3;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.interval, "interval", between(0.0, 60.0), "s",
           "While the robot is lost, its scans are searched among key scans as often as this, or "
           "each of them where they are 0.1 m and more apart.");
    option(self.key_scans, "key_scans", between(1, 1000), "",
           "Key scans that a scan is searched in at a time, 2 to 10 milliseconds each; up to five "
           "times as many where scans are rare or far apart. With 1 it is searched in no "
           "more after some 24 milliseconds, with more in proportion.");
    option(self.confirmations, "confirmations", between(1, 100), "",
           "A lost robot counts as found at a place near where odometry says where so many scans "
           "match well, and hardly one at another place.");
    option(self.far_confirmations, "far_confirmations", between(1, 100), "",
           "Scans that have to match well at a place that is not near where odometry says, since "
           "corridors and rooms may be alike.");
    option(self.least_score, "least_score", between(0.0, 1.0), "",
           "Scans that fit less than this do not confirm a place.");
    option(self.distance, "distance", between(0.05, 10.0), "m",
           "Way between scans that confirm a place; or as many radians.");
  }
};

/// Where a lost robot may be.
struct PlaceHypothesis {
  std::size_t part = 0;  ///< of the map
  Pose2 part_from_apart;
  int confirmations = 1;
  Pose2 apart_from_base;  ///< where it was looked at last
};

/// What is known of where a lost robot may be: a value, to be copied and saved. "Apart" is the
/// frame of the map that the robot makes meanwhile.
struct PlaceSearch {
  std::size_t next = 0;   ///< of the key scans that are searched
  bool complete = false;  ///< all of them have been
  double stamp = 0.0;     ///< [s] of the scan that was searched last
  std::vector<PlaceHypothesis> hypotheses;
};

}  // namespace matchbox_slam
