#include "tools/recording_request.hpp"

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "run/slam_node_options.hpp"

namespace matchbox_slam {

Parameters gather_parameters(const RecordingRequest& request,
                             const std::optional<std::string>& matcher) {
  Parameters parameters = read_yaml_parameters(request.config_files);
  if (matcher) {
    parameters.set("matcher", *matcher);
  }
  if (request.seed) {
    parameters.set("seed", *request.seed);
  }
  parameters.merge(frame_parameters(request.recording));
  parameters.merge(parse_overrides(request.overrides));
  for (const OptionDescription& row : describe_options(SlamNodeOptions{})) {
    if (parameters.find(row.name) != nullptr) {
      throw ConfigurationError(row.name + ": only the node has this option; leave it out");
    }
  }
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
