#include "tools/bag_flags.hpp"

namespace matchbox_slam {

void add_repeated(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                  const std::string& help, const std::string& type_name) {
  app.add_option(name, values, help + "; may be given repeatedly")
      ->allow_extra_args(false)
      ->type_name(type_name);
}

void add_bag_flags(CLI::App& app, BagRequest& request) {
  add_repeated(app, "--scan-topic", request.scan_topics, "Topic of the laser scans", "TOPIC");
  app.add_option("--base-frame", request.base_frame, "Frame of the robot")->type_name("FRAME");
  app.add_option("--odom-frame", request.odom_frame, "Frame of the odometry")->type_name("FRAME");
  app.add_flag("--no-odom", request.no_odometry, "Leave odometry aside, or there is none");
  app.add_option("--odom-topic", request.odom_topic,
                 "Topic of the odometry as nav_msgs/Odometry, where tf carries none")
      ->type_name("TOPIC");
  add_repeated(app, "--laser-pose", request.laser_poses,
               "Where the laser is on the base [m, rad], where tf does not tell; of several lasers "
               "in the order of --scan-topic",
               "X,Y,YAW");
  add_number<double>(app, "--start", request.period.start, between(0.0, 1e9),
                     "Begin this long after the bag begins", "SECONDS");
  add_number<double>(app, "--duration", request.period.duration, between(0.0, 1e9),
                     "Stop after this long; else at the end", "SECONDS");
}

void add_recording_flags(CLI::App& app, RecordingRequest& request, const std::string& seed_help,
                         const std::string& debug_help) {
  app.add_option("BAG", request.recording.bags,
                 "Files of one recording: bags of ROS 1, bags of ROS 2 (.db3, .mcap or their "
                 "folder), logs of CARMEN, by what is inside them")
      ->required();
  app.add_option("--out", request.out, "Folder for the results; made if need be")
      ->required()
      ->type_name("DIR");
  add_repeated(app, "--config", request.config_files, "YAML with parameters", "FILE");
  add_repeated(app, "--set", request.overrides,
               "A parameter of doc/parameters.md, as slam/insert_distance=0.3", "KEY=VALUE");
  add_bag_flags(app, request.recording);
  add_number<int>(app, "--seed", request.seed, at_least(0.0), seed_help);
  app.add_option("--debug", request.debug, debug_help)->type_name("DIR");
  app.add_flag("--quiet", request.quiet, "Only warnings and errors");
}

}  // namespace matchbox_slam
