#include "tools/bag_flags.hpp"

#include <sstream>

namespace matchbox_slam {

CLI::Option* add_repeated(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                          const std::string& help, const std::string& type_name) {
  const auto split = [&values](const std::string& joined) {
    std::istringstream stream(joined);
    for (std::string line; std::getline(stream, line);) {
      values.push_back(line);
    }
  };
  return app.add_option_function<std::string>(name, split, help + "; may be given repeatedly")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join)
      ->type_name(type_name);
}

void add_bag_flags(CLI::App& app, BagRequest& request) {
  add_optional(app, "--scan-topic", request.scan_topic, "Topic of the laser scans", "TOPIC");
  add_optional(app, "--base-frame", request.base_frame, "Frame of the robot", "FRAME");
  add_optional(app, "--odom-frame", request.odom_frame, "Frame of the odometry", "FRAME");
  app.add_flag("--no-odom", request.no_odometry, "Leave odometry aside, or there is none");
  app.add_option("--start", request.period.start, "Begin this long after the bag begins")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("SECONDS");
  app.add_option("--duration", request.period.duration, "Stop after this long")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("SECONDS");
}

}  // namespace matchbox_slam
