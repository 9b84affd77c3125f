#include "matchbox_slam/ros/scan_matcher_setup.hpp"

#include "matchbox_slam/ros/imu_heading.hpp"
#include "matchbox_slam/ros/setup_parts.hpp"
#include "matchbox_slam/ros/transform_store.hpp"

namespace matchbox_slam {

namespace {

GuessSource guess_source(const std::string& name) {
  if (name == "odometry") {
    return GuessSource::kOdometry;
  }
  return name == "imu" ? GuessSource::kHeading : GuessSource::kVelocity;
}

void check_frames(const ScanMatcherNodeOptions& options) {
  const auto refuse = [](const std::string& name, const std::string& value,
                         const std::string& text) {
    throw ConfigurationError(name + ": '" + value + "' is not allowed" + text);
  };
  if (options.base_frame.empty()) {
    refuse("base_frame", "", "; allowed: the frame of the robot, such as base_link");
  }
  if (options.odom_frame.empty() || options.odom_frame == options.base_frame) {
    refuse("odom_frame", options.odom_frame, "; allowed: a frame other than base_frame");
  }
  if (options.guess != "odometry") {
    if (!options.guess_frame.empty()) {
      refuse("guess_frame", options.guess_frame,
             " with guess '" + options.guess + "'; leave it out, or set guess to 'odometry'");
    }
    return;
  }
  if (options.guess_frame.empty() || options.guess_frame == options.base_frame) {
    refuse("guess_frame", options.guess_frame,
           " with guess 'odometry'; allowed: the frame in which the odometry moves, such as odom");
  }
  if (options.publish_tf && options.guess_frame == options.odom_frame) {
    refuse("odom_frame", options.odom_frame,
           " with publish_tf, since it is guess_frame: its link to the base is another's already; "
           "allowed: a frame of its own, such as scan_odom, or publish_tf: false");
  }
}

}  // namespace

ScanMatcherSetup make_scan_matcher_setup(const Parameters& parameters,
                                         const MatcherLoader& loader) {
  const std::vector<std::string> names = option_names<ScanMatcherNodeOptions>();
  reject_unknown_names(parameters, names, {"odometry", "scan", "map", "field", "motion", "slam"},
                       loader);
  ScanMatcherSetup setup;
  setup.node = read_options<ScanMatcherNodeOptions>(only(parameters, names), "");
  for (std::string* frame :
       {&setup.node.base_frame, &setup.node.odom_frame, &setup.node.guess_frame}) {
    *frame = without_leading_slash(*frame);
  }
  check_frames(setup.node);
  setup.guess = guess_source(setup.node.guess);
  setup.odometry = read_laser_odometry_settings(parameters);
  setup.matcher_name = loader.find(setup.node.matcher);
  setup.matcher = make_matcher(parameters, loader, setup.matcher_name);
  return setup;
}

ScanQueueSettings queue_settings(const ScanMatcherSetup& setup) {
  ScanQueueSettings settings;
  settings.base_frame = setup.node.base_frame;
  if (setup.guess == GuessSource::kOdometry) {
    settings.odom_frame = setup.node.guess_frame;
  } else if (setup.guess == GuessSource::kHeading) {
    settings.odom_frame = kImuHeadingFrame;
  }
  // What we publish comes back to us, and is no news.
  settings.map_frame = setup.node.publish_tf ? setup.node.odom_frame : "";
  settings.transform_timeout = setup.node.transform_timeout;
  settings.max_waiting = static_cast<std::size_t>(setup.node.queue_size);
  settings.scan_time_offset = ros::Duration(setup.node.scan_time_offset);
  return settings;
}

}  // namespace matchbox_slam
