#pragma once

#include <string>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

/// What concerns the node alone.
struct SlamNodeOptions {
  bool publish_tf = true;
  double transform_publish_period = 0.05;
  double transform_tolerance = 0.1;
  std::string tf_while_lost = "hold";
  double map_update_interval = 1.0;
  std::string initial_map;
  std::string map_file = "map";
  double autosave_period = 0.0;
  bool resume = false;
  std::string trajectory_file;
  std::string events_file;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.publish_tf, "publish_tf", any(), "",
           "Whether to publish the transform map -> odom (map -> base without odometry).");
    option(
        self.transform_publish_period, "transform_publish_period", between(0.001, 10.0), "s",
        "Time from one repetition of the transform to the next, by the ROS clock; each scan sends "
        "it at once.");
    option(self.transform_tolerance, "transform_tolerance", between(0.0, 10.0), "s",
           "Published transforms are stamped this far ahead, so that listeners need not wait.");
    option(self.tf_while_lost, "tf_while_lost", one_of({"hold", "stop", "best"}), "",
           "What is published as map -> odom while the robot is lost: the last one of when it was "
           "not; nothing; or the best guess, which may be wrong by any distance.");
    option(self.map_update_interval, "map_update_interval", between(0.05, 3600.0), "s",
           "Shortest time between two maps that are published, by the wall clock.");
    option(self.initial_map, "initial_map", any(), "",
           "Map to go on with: a .slam file of ~save_map, or a .yaml file as of map_server; empty: "
           "none.");
    option(self.map_file, "map_file", any(), "",
           "~save_map writes this path + .pgm (see map_format), .yaml, .png and .slam.");
    option(self.autosave_period, "autosave_period", between(0.0, 86400.0), "s",
           "So long after it was saved last the map is saved, if scans were used since, and at the "
           "end of the node as by ~save_map; by the wall clock. 0: never.");
    option(self.resume, "resume", any(), "",
           "Whether to go on with map_file + .slam, where there is one, instead of initial_map.");
    option(self.trajectory_file, "trajectory_file", any(), "",
           "~save_map and the end of the node write the trajectory here (TUM); empty: nowhere.");
    option(self.events_file, "events_file", any(), "",
           "They write here what happened between the scans, such as poses told and resets, for "
           "map_bag --events to repeat; empty: nowhere.");
  }
};

}  // namespace matchbox_slam
