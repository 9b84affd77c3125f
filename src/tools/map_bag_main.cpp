// rosrun matchbox_slam map_bag: maps a bag without a roscore.

#include <CLI/CLI.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "matchbox_slam/ros/bag_mapper.hpp"
#include "matchbox_slam/ros/terminal.hpp"
#include "run_program.hpp"

namespace {

using matchbox_slam::MapBagRequest;

/// Options that may be given several times, one value each, so that they take no bag for a value.
struct RepeatedOptions {
  std::string config_files;
  std::string overrides;
};

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> values;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    values.push_back(line);
  }
  return values;
}

/// An option whose value stays unset unless it is given.
template <typename Value>
CLI::Option* add_optional(CLI::App& app, const std::string& name, std::optional<Value>& value,
                          const std::string& help, const std::string& type_name) {
  CLI::Option* option = app.add_option_function<Value>(
      name, [&value](const Value& given) { value = given; }, help);
  return option->type_name(type_name);
}

void declare_options(CLI::App& app, MapBagRequest& request, RepeatedOptions& repeated,
                     bool& quiet) {
  app.add_option("BAG", request.bags, "Bag files of one recording")->required();
  app.add_option("--out", request.out, "Folder for the results; made if need be")
      ->required()
      ->type_name("DIR");
  app.add_option("--config", repeated.config_files, "YAML with parameters; may be given repeatedly")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join)
      ->type_name("FILE");
  add_optional(app, "--matcher", request.matcher, "Scan matcher, such as monte_carlo", "NAME");
  app.add_option("--set", repeated.overrides, "A parameter; may be given repeatedly")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join)
      ->type_name("KEY=VALUE");
  add_optional(app, "--scan-topic", request.scan_topic, "Topic of the laser scans", "TOPIC");
  add_optional(app, "--base-frame", request.base_frame, "Frame of the robot", "FRAME");
  add_optional(app, "--odom-frame", request.odom_frame, "Frame of the odometry", "FRAME");
  app.add_flag("--no-odom", request.no_odometry, "Map from the laser alone");
  app.add_option("--start", request.period.start, "Begin this long after the bag begins")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("SECONDS");
  app.add_option("--duration", request.period.duration, "Stop after this long")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("SECONDS");
  add_optional(app, "--seed", request.seed, "Of the random numbers", "N")
      ->check(CLI::Range(0, 2147483647));
  app.add_option("--threads", request.threads, "From 2 on, the bag is read by a thread of its own")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  app.add_flag("--quiet", quiet, "Only warnings and errors");
}

}  // namespace

int main(int argc, char** argv) {
  const matchbox_slam::InterruptGuard interrupt;
  MapBagRequest request;
  RepeatedOptions repeated;
  bool quiet = false;
  return matchbox_slam::run_program(
      "map_bag", "Maps the laser scans of a bag and writes map, trajectory and a report.",
      [&](CLI::App& app) { declare_options(app, request, repeated, quiet); }, argc, argv,
      [&] {
        request.config_files = lines(repeated.config_files);
        request.overrides = lines(repeated.overrides);
        matchbox_slam::Terminal terminal(quiet);
        matchbox_slam::map_bag(request, {[&](const std::string& line) { terminal.inform(line); },
                                         [&](const std::string& line) { terminal.warn(line); },
                                         [&](double fraction, const std::string& text) {
                                           terminal.show_progress(fraction, text);
                                         },
                                         [&] { return interrupt.is_interrupted(); }});
      });
}
