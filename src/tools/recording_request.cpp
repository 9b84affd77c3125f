#include "tools/recording_request.hpp"

#include <fmt/core.h>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "run/slam_node_options.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

namespace {

void reject_options_of_node(const Parameters& parameters) {
  for (const OptionDescription& row : describe_options(SlamNodeOptions{})) {
    if (parameters.find(row.name) != nullptr) {
      throw ConfigurationError(row.name + ": only the node has this option; leave it out");
    }
  }
}

void require_allowed(const Parameters& parameters) {
  reject_options_of_node(parameters);
  static_cast<void>(make_slam_setup(parameters, MatcherLoader(), SetupOf::kProgram));
}

/// Where something is wrong with what files say, whether alone or not, the file and line are told
/// of what is wrong alone.
void check_files(const std::vector<std::string>& files, const Parameters& of_files) {
  try {
    require_allowed(of_files);
  } catch (const ConfigurationError&) {
    for (const auto& [name, place] : places_in_yaml(files)) {
      if (const ParameterValue* value = of_files.find(name)) {
        Parameters alone;
        alone.set(name, *value);
        try {
          require_allowed(alone);
        } catch (const ConfigurationError& error) {
          throw ConfigurationError(fmt::format("{}: {}", place, error.what()));
        }
      }
    }
  }
}

}  // namespace

Parameters gather_parameters(const RecordingRequest& request,
                             const std::optional<std::string>& matcher) {
  Parameters given;
  if (matcher) {
    given.set("matcher", *matcher);
  }
  if (request.seed) {
    given.set("seed", *request.seed);
  }
  given.merge(frame_parameters(request.recording));
  given.merge(parse_overrides(request.overrides));
  Parameters of_files;  // but for what is given besides
  const Parameters in_files = read_yaml_parameters(request.config_files);
  for (const auto& [name, value] : in_files.values()) {
    if (given.find(name) == nullptr) {
      of_files.set(name, value);
    }
  }
  check_files(request.config_files, of_files);
  Parameters parameters = of_files;
  parameters.merge(given);
  reject_options_of_node(parameters);
  return parameters;
}

void require_writable_folders(const RecordingRequest& request) {
  if (request.out.empty()) {
    throw ConfigurationError("--out: '' is no name of a folder");
  }
  require_writable_folder(request.out);
  if (!request.debug.empty()) {
    require_writable_folder(request.debug);
  }
}

}  // namespace matchbox_slam
