#pragma once

#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "run/shared_run_options.hpp"

namespace matchbox_slam {

/// What the node and map_bag have in common besides the engine and the matcher. Names are
/// gmapping's where the meaning is.
struct RunOptions : SharedRunOptions {
  std::vector<std::string> scan_topics;
  std::string map_frame = "map";
  bool use_odometry = true;
  std::string odom_topic;
  std::string imu_topic;
  std::vector<double> laser_pose;
  double max_lag = 0.0;
  std::string scan_time_offset = "0";
  std::string time_jump = "go_on";
  std::string map_format = "pgm";
  double start_x = 0.0;
  double start_y = 0.0;
  double start_theta = 0.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    visit_matcher(self, option);
    option(
        self.scan_topics, "scan_topics", any(), "",
        "Topics of the robot's lasers where it has several. The first one leads: others are used "
        "once they are seen to agree with it, so name the better one first. Empty: the node takes "
        "scan, map_bag the only one there is.");
    option(self.seed, "seed", at_least(0.0), "",
           "Of the random numbers; the same seed gives the same map.");
    option(self.base_frame, "base_frame", any(), "",
           "Frame of the robot whose pose is estimated. map_bag finds it when it is not given.");
    option(self.odom_frame, "odom_frame", any(), "",
           "Frame in which the odometry moves. map_bag finds it when it is not given.");
    option(self.map_frame, "map_frame", any(), "", "Frame of the map.");
    option(self.use_odometry, "use_odometry", any(), "",
           "Whether tf carries odometry; if not, the base moves at constant velocity until the "
           "match.");
    option(self.odom_topic, "odom_topic", any(), "",
           "Topic of the odometry as nav_msgs/Odometry, where tf carries none: its pose is that of "
           "its child_frame_id (empty: base_frame) in odom_frame. Empty: tf, and in map_bag the "
           "topic that is found where tf has none.");
    option(self.imu_topic, "imu_topic", any(), "",
           "Topic of an IMU, sensor_msgs/Imu: roll and pitch of the base by its orientation are "
           "taken out of the scans where odometry shows none; without odometry it tells the turn "
           "between scans, too, by its rate of turn where it has no orientation. Empty: none.");
    option(self.laser_pose, "laser_pose", between(-1000.0, 1000.0), "",
           "Where the laser is on the base, where tf does not tell: [x, y, yaw] in m and rad, as a "
           "list or as text; of several lasers one after another, in the order of scan_topics. "
           "Upside down it cannot be then. Empty: tf tells.");
    option(self.transform_timeout, "transform_timeout", between(0.0, 3600.0), "s",
           "A scan waits this long for its transforms, then it is skipped.");
    visit_queue_size(self, option);
    option(self.max_lag, "max_lag", between(0.0, 3600.0), "s",
           "A scan that waited longer than this is skipped when a newer one is there, for robots "
           "that need the pose of now; 0: none is.");
    option(self.scan_time_offset, "scan_time_offset", any(), "s",
           "Added to the stamps of scans, whose clock may differ from tf's; a number, or 'auto': "
           "what the first seconds tell.");
    option(
        self.time_jump, "time_jump", one_of({"go_on", "reset", "stop"}), "",
        "When time jumps back by more than 1 s, as when a clock is set or a bag played again: go "
        "on in the map, start a new one, or stop.");
    option(
        self.map_format, "map_format", one_of({"pgm", "png"}), "",
        "In what a saved map's image is that its .yaml names: .pgm, or .occupancy.png beside the "
        "picture .png.");
    option(self.start_x, "start_x", between(-1e8, 1e8), "m",
           "x of the base in the map at the first scan.");
    option(self.start_y, "start_y", between(-1e8, 1e8), "m",
           "y of the base in the map at the first scan.");
    option(self.start_theta, "start_theta", any(), "rad",
           "Heading of the base in the map at the first scan.");
  }
};

}  // namespace matchbox_slam
