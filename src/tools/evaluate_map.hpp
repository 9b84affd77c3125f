#pragma once

#include <CLI/CLI.hpp>

namespace matchbox_slam {

/// Adds `map MAP.yaml... --plot FILE.png` to the program; its callback prints the results to stdout
/// and writes the picture. The callback throws FileError and EvaluationError.
void add_map_command(CLI::App& app);

}  // namespace matchbox_slam
