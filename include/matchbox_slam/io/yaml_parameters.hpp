#pragma once

#include <map>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// Reads parameters from YAML text: nested maps become names joined with '/', and a name may hold
/// '/' itself, as in files for `rosparam`. A list of numbers becomes numbers, any other list texts;
/// quoted scalars are text.
/// @param source  names the text in errors, such as the file's path.
/// Throws ConfigurationError with source and line for broken YAML, a name that is given twice or
/// has empty parts, a name without value, and lists of anything but scalars.
[[nodiscard]] Parameters parse_yaml_parameters(const std::string& text, const std::string& source);

/// Reads YAML files in order; where two give the same name, the later one counts.
/// Throws ConfigurationError also when a file cannot be read.
[[nodiscard]] Parameters read_yaml_parameters(const std::vector<std::string>& paths);

/// Where these files give each name: "FILE:LINE"; where two do, the later one.
[[nodiscard]] std::map<std::string, std::string> places_in_yaml(
    const std::vector<std::string>& paths);

/// One map of a YAML list.
struct ParameterEntry {
  int line = 0;  ///< where it begins
  Parameters parameters;
};

/// Reads a YAML file that is a list of maps, each as parse_yaml_parameters does; an empty file is
/// an empty list. Throws ConfigurationError with file and line.
[[nodiscard]] std::vector<ParameterEntry> read_yaml_list(const std::string& path);

/// Reads assignments from a command line, `monte_carlo/max_tries=500` each; the value is typed as
/// in YAML, lists as `[1, 2]`. The later of two for the same name counts. Throws ConfigurationError
/// naming the assignment.
[[nodiscard]] Parameters parse_overrides(const std::vector<std::string>& assignments);

/// The parameters as YAML, nested and sorted by name. Reading the text back gives the same values.
/// Throws ConfigurationError when a name is both a value and a section of others.
[[nodiscard]] std::string to_yaml(const Parameters& parameters);

}  // namespace matchbox_slam
