#include "node/node_program.hpp"

#include <fmt/core.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <algorithm>
#include <csignal>
#include <exception>
#include <iostream>

#include "common/version.hpp"

namespace matchbox_slam {
namespace {

volatile std::sig_atomic_t signalled = 0;  // a handler of signals reaches nothing else

void print_help(const std::string& name, const std::vector<OptionDescription>& options) {
  std::cout << "Usage: " << name << "_node [_NAME:=VALUE]... [TOPIC:=OTHER_TOPIC]...\n"
            << "A ROS node; needs a roscore. `roslaunch --ros-args matchbox_slam " << name
            << ".launch` lists\n"
            << "the arguments of its launch file. Parameters of its own, besides those of matchers "
               "and of map,\nmotion and the like, which doc/parameters.md lists:\n";
  for (const OptionDescription& option : options) {
    std::cout << "  " << option.name << " (" << to_string(option.value) << "): " << option.meaning
              << '\n';
  }
}

/// What is wrong with the first argument that is not NAME:=VALUE. Empty: there is none.
std::string find_stray(int argc, char** argv) {
  const auto found = std::find_if(argv + 1, argv + argc, [](const std::string& argument) {
    return !argument.empty() && argument.find(":=") == std::string::npos;
  });
  if (found == argv + argc) {
    return "";
  }
  const std::string argument = *found;
  return argument[0] == '-' ? fmt::format("unknown option '{}'", argument)
                            : fmt::format(
                                  "'{}' is no argument; allowed: _NAME:=VALUE and "
                                  "TOPIC:=OTHER_TOPIC, such as _matcher:=olson",
                                  argument);
}

}  // namespace

int run_node(int argc, char** argv, const std::string& name,
             const std::vector<OptionDescription>& options, const MakeNode& make) {
  if (std::any_of(argv + 1, argv + argc, [](const std::string& argument) {
        return argument == "--help" || argument == "-h";
      })) {
    print_help(name, options);
    return 0;
  }
  if (std::find(argv + 1, argv + argc, std::string("--version")) != argv + argc) {
    std::cout << version_text(name + "_node") << '\n';
    return 0;
  }
  if (const std::string defect = find_stray(argc, argv); !defect.empty()) {
    std::cerr << name << ": " << defect << "; see --help\n";
    return 2;
  }
  try {
    ros::init(argc, argv, name);
  } catch (const ros::Exception& error) {  // names, the node's own one, ports
    std::cerr << name << ": ROS does not take the arguments: " << error.what()
              << "; a parameter of the node begins with '_', such as _max_lag:=3\n";
    return 2;
  }
  // While the node starts it may wait for a master, which only roscpp's own way of ending ends;
  // that heeds SIGINT alone.
  std::signal(SIGTERM, [](int /*signal*/) { ros::requestShutdown(); });
  // These outlive the node: with the last handle gone, ROS would not log what went wrong any more.
  const ros::NodeHandle node_handle;
  const ros::NodeHandle private_handle("~");
  try {
    const std::shared_ptr<void> node = make(node_handle, private_handle);
    for (const int signal : {SIGINT, SIGTERM}) {
      std::signal(signal, [](int /*signal*/) { signalled = 1; });
    }
    while (ros::ok() && signalled == 0) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
    }
  } catch (const ConfigurationError& error) {
    ROS_FATAL_STREAM(name << ": " << error.what());
    return 2;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(name << ": " << error.what());
    return 1;
  }
  return 0;
}

}  // namespace matchbox_slam
